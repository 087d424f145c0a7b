#!/usr/bin/env bash
# The manifests: kustomize takes them, every key is one that Kubernetes knows, references meet, and every flag, setting,
# path and metric that they name exists in the programs. No cluster is needed.
source "$(dirname "$0")/lib.sh"
command -v kubectl >/dev/null || cannot "needs kubectl: deploy/setup.sh --test"
python3 -c 'import yaml' 2>/dev/null || cannot "needs python3-yaml: deploy/setup.sh --test"
check=$here/kubernetes_check.py

cp -r "$here/../../deploy/kubernetes" manifests
# As docs/KUBERNETES.md tells.
mkdir manifests/keys
expect 0 "$evograsp" keygen manifests/keys/server.key
expect 0 "$evograsp" keygen manifests/keys/worker.key --server manifests/keys/server.key --allow manifests/keys/workers.allow
head -c 24 /dev/urandom | base64 >manifests/keys/token
kubectl kustomize manifests >all.yaml || fail "kustomize does not take the manifests"
python3 "$check" all.yaml || fail "the manifests are not right"

# The check itself sees mistakes: each of these is one.
mistake() { # WHAT SED-COMMAND
  sed "$2" all.yaml >wrong.yaml
  if cmp -s all.yaml wrong.yaml; then fail "mistake '$1' is none: the manifests have changed"; fi
  if python3 "$check" wrong.yaml >/dev/null; then fail "the check does not see: $1"; fi
}
mistake "a misspelt key" 's/periodSeconds:/periodSecond:/'
mistake "a wrong type" 's/runAsNonRoot: true/runAsNonRoot: "yes"/'
mistake "a bad quantity" 's/512Mi/512MB/'
mistake "an unknown API version" 's,autoscaling/v2,autoscaling/v9,'
mistake "a port that is not there" 's/port: workers/port: worker/'
mistake "a volume that is not there" 's,mountPath: /keys,mountPath: /secrets,'
mistake "a secret that is not there" 's/secretName: evograsp-worker-keys/secretName: evograsp-keys/'

# What they name, in the programs.
python3 "$check" --named all.yaml >named
"$evograsp" train quick --out run --quiet --slots 2 --set run.generations=1 --set neat.population=10 || fail "no run"
EVOGRASP_TOKEN=0123456789abcdef "$server" --resume run --stay --listen 'tcp://127.0.0.1:*' --http 127.0.0.1:0 \
  --rendezvous where 2>log &
server_pid=$!
trap 'kill $server_pid 2>/dev/null; wait $server_pid 2>/dev/null; rm -rf "$folder"' EXIT
within 90 test -s where || fail "no server: $(cat log)"
url=$(sed -n 's/^http = //p' where)
count=0
while read -r what first second; do
  count=$((count + 1))
  case $what in
    flag) grep -q -- "^ *${second}[ ,]" <<<"$("$bin/$first" --help)" || fail "$first has no option $second" ;;
    key) "$evograsp" validate quick --set "$first=x" >/dev/null 2>&1 || fail "no setting $first" ;;
    path) curl -sf "$url$first" >/dev/null || fail "the server does not answer at $first" ;;
    metric) grep -q "^$first " <<<"$(curl -sf "$url/metrics")" || fail "no metric $first" ;;
    *) fail "what is '$what'?" ;;
  esac
done <named
[ $count -ge 12 ] || fail "only $count things are named: $(cat named)"
# The ports of the containers are those that the programs are told.
while read -r port; do
  grep -q -- "- --.*=.*:$port\$" all.yaml || fail "nothing listens at port $port"
done < <(sed -n 's/^ *- containerPort: //p' all.yaml)
grep -q -- "--connect=tcp://evograsp-server:5555" all.yaml || fail "workers do not go to the service"
finish
