#compdef corbslam map_store fusion_worker map_viewer client_agent simulated_agent
# Completes our programs' command lines from what their own --help says, in bash and, by its bashcompinit, in zsh.
if [ -n "${ZSH_VERSION:-}" ]; then autoload -Uz bashcompinit && bashcompinit; fi

# shellcheck disable=SC2207
_corbslam_complete() {
  local cur="${COMP_WORDS[COMP_CWORD]}" flag="${COMP_WORDS[COMP_CWORD-1]}" word help value
  local -a asked
  asked=("${COMP_WORDS[0]}")
  COMPREPLY=()
  # What looks like the name of a command may be a flag's value, which --help passes over.
  for word in "${COMP_WORDS[@]:1:$((COMP_CWORD - 1))}"; do
    if [[ "$word" =~ ^[a-z][a-z-]*$ ]]; then asked+=("$word"); fi
  done
  help=$({ "${asked[@]}" --help-all || "${asked[@]}" --help; } 2>/dev/null)
  if [[ "$flag" == --* ]]; then
    value=$(sed -n -E "s/^  ([-a-z]+,)?$flag(,[-a-z]+)? ([A-Za-z0-9:|]+)( .*|\$)/\3/p" <<<"$help")
    case "$value" in
      *'|'*) COMPREPLY=($(compgen -W "${value//|/ }" -- "$cur")); return ;;
      ?*) return ;;  # Names of files come from -o default.
    esac
  fi
  COMPREPLY=($(compgen -W "$(sed -n -E 's/^  (-h,)?(--)?([a-z][-a-z]*).*/\2\3/p' <<<"$help")" -- "$cur"))
}
complete -o default -F _corbslam_complete corbslam map_store fusion_worker map_viewer client_agent simulated_agent
# As a file of zsh's $fpath this is run for a first time to complete.
if [ -n "${compstate+set}" ]; then _bash_complete -o default -F _corbslam_complete; fi
