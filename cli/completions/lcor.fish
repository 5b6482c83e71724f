# SPDX-License-Identifier: MIT
# Fish completion for lcor: commands and options come from its own --help, so they are never stale.
function __lcor_options
    set -l words (commandline -opc)
    test (count $words) -ge 2; or return
    lcor $words[2] --help 2>/dev/null | string replace -rf '^  (-[-a-z]*) *(.*)$' '$1\t$2'
end
complete -c lcor -n __fish_use_subcommand -f -a '(lcor --help 2>/dev/null | string replace -rf "^  ([a-z]+) +(.*)\$" "\$1\t\$2")'
complete -c lcor -n 'not __fish_use_subcommand; and string match -q -- "-*" (commandline -ct)' -f -a '(__lcor_options)'
