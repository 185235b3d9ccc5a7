# Completion of riot for bash 3.2 and later.
_riot_table() {
    cat <<'RIOT_TABLE'
@TABLE@
RIOT_TABLE
}

_riot() {
    local line="${COMP_LINE:0:COMP_POINT}" command="" deeper previous="" current="" follows="" files="" index
    local at kind word meaning
    local -a words
    read -r -a words <<<"$line"
    if [[ $line == *[[:space:]] ]]; then words+=(""); fi
    current="${words[${#words[@]} - 1]}"
    for ((index = 1; index < ${#words[@]} - 1; index++)); do
        previous="${words[index]}"
        deeper="${command:+$command }$previous"
        while IFS='|' read -r at kind word meaning; do
            if [[ $kind == c && $at == "$command" && $word == "$previous" ]]; then
                command="$deeper"
                break
            fi
        done < <(_riot_table)
    done
    COMPREPLY=()
    while IFS='|' read -r at kind word meaning; do
        [[ $at == "$command" ]] || continue
        if [[ ($kind == p || $kind == a) && $word == "$previous" ]]; then
            follows=$kind
            COMPREPLY=()
        fi
        if [[ -n $follows ]]; then
            if [[ $kind == v && $word == "$previous $current"* ]]; then COMPREPLY+=("${word#* }"); fi
            continue
        fi
        case "$current" in
        -*) if [[ $kind == [opa] && $word == "$current"* ]]; then COMPREPLY+=("$word"); fi ;;
        *=*) if [[ $kind == v && $word == "$current"* ]]; then COMPREPLY+=("$word"); fi ;;
        *)
            if [[ $kind == [cn] && $word == "$current"* ]]; then COMPREPLY+=("$word"); fi
            if [[ $kind == f ]]; then files=yes; fi
            ;;
        esac
    done < <(_riot_table)
    if [[ $follows == p || -z $follows && -n $files && $current != -* ]]; then
        while read -r word; do COMPREPLY+=("$word"); done < <(compgen -f -- "$current")
        compopt -o filenames 2>/dev/null
    elif [[ -z $follows && $current != -* && $current == *=* && ${#COMPREPLY[@]} == 0 ]]; then
        while read -r word; do COMPREPLY+=("${current%%=*}=$word"); done < <(compgen -f -- "${current#*=}")
    fi
    if [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *= ]]; then compopt -o nospace 2>/dev/null; fi
    # Where = ends a word, the shell replaces only what follows it.
    if [[ $current == *=* && $COMP_WORDBREAKS == *=* ]]; then
        for index in "${!COMPREPLY[@]}"; do COMPREPLY[index]="${COMPREPLY[index]#"${current%"${current##*=}"}"}"; done
    fi
}

complete -F _riot riot
