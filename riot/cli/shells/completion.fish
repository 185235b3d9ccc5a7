# Completion of riot for fish.
function __riot_table
    echo '@TABLE@'
end

function __riot_candidates
    set -l typed (commandline -opc)
    set -l current (commandline -ct)
    set -l command ''
    set -l previous ''
    set -l follows ''
    for word in $typed[2..-1]
        set previous $word
        for line in (__riot_table)
            set -l fields (string split -m 3 '|' -- $line)
            if test "$fields[2]" = c; and test "$fields[1]" = "$command"; and test "$fields[3]" = "$word"
                set command (string trim -- "$command $word")
                break
            end
        end
    end
    for line in (__riot_table)
        set -l fields (string split -m 3 '|' -- $line)
        test "$fields[1]" = "$command"; or continue
        set -l kind $fields[2]
        set -l word $fields[3]
        if contains -- $kind p a; and test "$word" = "$previous"
            set follows $kind
        end
        if test -n "$follows"
            if test $kind = v; and string match -q -- "$previous *" "$word"
                string replace -- "$previous " '' "$word"
            end
        else if string match -q -- '-*' "$current"
            contains -- $kind o p a; and printf '%s\t%s\n' $word $fields[4]
        else if string match -q -- '*=*' "$current"
            test $kind = v; and echo $word
        else if contains -- $kind c n
            printf '%s\t%s\n' $word $fields[4]
        else if test $kind = f
            __fish_complete_path "$current"
        end
    end
    if test "$follows" = p
        __fish_complete_path "$current"
    end
end

complete -c riot -f -a '(__riot_candidates)'
