# SPDX-License-Identifier: MIT
# Bash completion for lcor: commands and options come from its own --help, so they are never stale.
_lcor() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
    COMPREPLY=()
    if ((COMP_CWORD == 1)); then
        local commands
        commands=$(lcor --help 2>/dev/null | sed -n 's/^  \([a-z]*\)  .*/\1/p')
        mapfile -t COMPREPLY < <(compgen -W "$commands --help --version" -- "$word")
        return
    fi
    local help
    help=$(lcor "$command" --help 2>/dev/null)
    local words=
    # `--reading patch|texel` in the help: complete the words.
    if [[ $before == --* ]]; then
        words=$(sed -n "s/^  $before \([a-z0-9-]*|[a-z0-9|-]*\).*/\1/p" <<<"$help" | tr '|' ' ')
    fi
    if [[ -n $words ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    elif [[ $word == -* ]]; then
        local options
        options=$(sed -n 's/^  \(-[-a-z]*\).*/\1/p' <<<"$help")
        mapfile -t COMPREPLY < <(compgen -W "$options --help --version" -- "$word")
    else
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    fi
}
complete -F _lcor lcor
