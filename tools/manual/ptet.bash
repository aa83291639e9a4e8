# Completion of ptet for bash, written by ptet manual.
_ptet() {
  local current=${COMP_WORDS[COMP_CWORD]} words=
  if [[ $COMP_CWORD -eq 1 || ${COMP_WORDS[1]} == help ]]; then
    words="build extract view info measure verify dump help --version --help -h"
  else
    case ${COMP_WORDS[1]} in
      build) words="--help -h --output -o --field --max-field-error --max-domain-error --target-vertices --min-quality --method --objective --predict --evaluate --max-star --pieces --weld --weld-within --keep-order --threads --memory-limit --checkpoint --checkpoint-every --resume --force --json --quiet -q" ;;
      extract) words="--help -h --output -o --field-error --domain-error --tets --vertices --bytes --milliseconds --focus --focus-error --focus-falloff --isovalue --values --view --pixels --outside --memory-limit --errors --input-order --salvage --json" ;;
      view) words="--help -h --show --colour --color --range --error --tets --vertices --focus --plane --isovalue --camera --size --screenshot --split --no-edges --no-text" ;;
      info) words="--help -h --levels --json" ;;
      measure) words="--help -h --field --exact --samples --seed --tolerance --threads --errors --weld --weld-within --json" ;;
      verify) words="--help -h --original --samples --json" ;;
      dump) words="--help -h --annotate" ;;
      help) words="--help -h" ;;
    esac
    [[ $current == -* ]] || words= # then it is a file, or a value
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}
complete -o default -F _ptet ptet
