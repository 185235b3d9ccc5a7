#compdef riot
# Completion of riot for zsh.
_riot_table() {
    cat <<'RIOT_TABLE'
@TABLE@
RIOT_TABLE
}

_riot() {
    local command="" previous="" current="${words[CURRENT]}" follows="" files="" index at kind word meaning
    local -a matches shown names
    for ((index = 2; index < CURRENT; index++)); do
        previous="${words[index]}"
        while IFS='|' read -r at kind word meaning; do
            if [[ $kind == c && $at == "$command" && $word == "$previous" ]]; then
                command="${command:+$command }$previous"
                break
            fi
        done < <(_riot_table)
    done
    while IFS='|' read -r at kind word meaning; do
        [[ $at == "$command" ]] || continue
        if [[ ($kind == p || $kind == a) && $word == "$previous" ]]; then
            follows=$kind
            matches=() shown=() names=()
        fi
        if [[ -n $follows ]]; then
            if [[ $kind == v && $word == "$previous "* ]]; then
                matches+=("${word#* }") shown+=("${word#* }")
            fi
            continue
        fi
        case "$current" in
        -*) if [[ $kind == [opa] ]]; then matches+=("$word") shown+=("$word  $meaning"); fi ;;
        *=*) if [[ $kind == v ]]; then matches+=("$word") shown+=("$word"); fi ;;
        *)
            if [[ $kind == c ]]; then matches+=("$word") shown+=("$word  $meaning"); fi
            if [[ $kind == n ]]; then names+=("$word"); fi
            if [[ $kind == f ]]; then files=yes; fi
            ;;
        esac
    done < <(_riot_table)
    if ((${#matches})); then compadd -l -d shown -a matches; fi
    if ((${#names})); then compadd -S '' -a names; fi
    if [[ $follows == p || -z $follows && -n $files && $current != -* ]]; then
        _files
    elif [[ -z $follows && $current != -* && $current == *=* ]]; then
        compset -P '*=' && _files
    fi
}

if [[ ${funcstack[1]:-} == _riot ]]; then _riot "$@"; else compdef _riot riot; fi
