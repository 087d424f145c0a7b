#!/usr/bin/env bash
# The units: systemd understands every line (it says what it does not on standard error alone, and exits with 0), they
# expose little, and the flags they use exist. What the programs tell the manager: tests/server/service_integration_test.cpp.
source "$(dirname "$0")/lib.sh"
command -v systemd-analyze >/dev/null || cannot "needs systemd-analyze: deploy/setup.sh --test"

# As docs/SYSTEMD.md installs them.
install -D -t root/usr/local/bin "$server" "$worker"
install -D -m 644 -t root/etc/systemd/system "$here"/../../deploy/systemd/*.service
mkdir -p root/usr/lib/systemd
cp -r /lib/systemd/system root/usr/lib/systemd/
ln -s usr/lib root/lib
units=(evograsp-server.service evograsp-worker@lab.service)

systemd-analyze verify --root=root "${units[@]}" 2>complaints || fail "systemd-analyze verify"
[ ! -s complaints ] || fail "systemd complains: $(cat complaints)"
# Of 10: above 9 is "unsafe", a unit without any hardening has 9.6.
for unit in "${units[@]}"; do
  systemd-analyze security --offline=yes --root=root --threshold=15 "$unit" >exposure 2>&1 ||
    fail "$unit is exposed more than 1.5: $(grep -e '→' -e '✗' exposure)"
  grep 'Overall exposure' exposure
done

# The checks see mistakes.
sed -i 's/^ProtectSystem=/ProtectSystems=/' root/etc/systemd/system/evograsp-server.service
systemd-analyze verify --root=root evograsp-server.service 2>complaints
[ -s complaints ] || fail "a misspelt key goes unseen"
sed -i '/^Protect\|^Private/d' root/etc/systemd/system/evograsp-server.service
if systemd-analyze security --offline=yes --root=root --threshold=15 evograsp-server.service >/dev/null 2>&1; then
  fail "a unit without protection goes unseen"
fi

for unit in server worker@; do
  program=evograsp-${unit%@}
  line=$(grep '^ExecStart=' "$here/../../deploy/systemd/evograsp-$unit.service")
  [[ $line == "ExecStart=/usr/local/bin/$program "* ]] || fail "$unit does not start $program"
  while read -r flag; do
    grep -q -- "^ *${flag}[ ,]" <<<"$("$bin/$program" --help)" || fail "$program has no option $flag"
  done < <(grep -o -- ' --[a-z-]*' <<<"$line" | tr -d ' ')
done
finish
