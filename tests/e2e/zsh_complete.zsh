# zsh_complete.zsh SCRIPT LINE: the line that Tab makes of LINE in an interactive zsh that has read SCRIPT.
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "PS1= RPS1=; autoload -Uz compinit; compinit -u -D; source ${(q)1}"
zpty -w shell 'show() { print -r -- "<line>$BUFFER<end>" }; zle -N show; bindkey "^X" show; bindkey "^I" complete-word'
zpty -w shell 'print read''y'
while zpty -r shell line; do [[ $line == ready* ]] && break; done
zpty -w -n shell "$2"$'\t\C-X'
while zpty -r shell line; do
  if [[ $line == *'<line>'*'<end>'* ]]; then
    line=${line##*<line>}
    print -r -- "${${line%%<end>*}%% #}"
    break
  fi
done
zpty -d shell
