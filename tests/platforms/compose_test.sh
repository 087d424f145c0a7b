#!/usr/bin/env bash
# docker-compose up with the real image: a server and three workers; one is killed, the rest are scaled, the server is
# restarted. The champion has the bytes of a run without containers. The image holds all it needs, and no more rights.
source "$(dirname "$0")/lib.sh"
source "$here/containers.sh"
reason=$(containers_possible) || cannot "$reason"
compose() { inside docker-compose --project-directory "$folder" -f "$here/../../docker-compose.yml" -f small.yml "$@" >>compose.log 2>&1; }
clean_up() {
  if [ -n "${service:-}" ]; then compose down --volumes --timeout 2; fi
  containers_down
  rm -rf "$folder"
}
trap clean_up EXIT

small=(run.generations=150 champion.candidates=4 champion.validation_trials=10)
"$evograsp" train quick --out local --slots 2 --quiet "${small[@]/#/--set=}" || fail "the run without containers failed"
containers_up || { fail "no containers: $(cat service.log)"; finish; }
product_image || { fail "no image"; finish; }

# ---- the image ----
run_in_image() { inside "${podman[@]}" run --rm --network none --read-only localhost/evograsp:latest "$@"; }
run_in_image sh -c 'exec 2>&1; id -u; ldd /usr/local/bin/evograsp*; touch /usr/local/x; ls /usr/local' >inside.txt 2>>podman.log
[ "$(head -n 1 inside.txt)" = 10001 ] || fail "the image's user is $(head -n 1 inside.txt)"
if grep 'not found' inside.txt; then fail "setup.sh --runtime leaves libraries out"; fi
grep -q 'Read-only file system' inside.txt || fail "the root can be written to"
for program in evograsp evograsp-server evograsp-worker; do
  [ "$(run_in_image "$program" --version 2>>podman.log)" = "$("$bin/$program" --version)" ] || fail "$program does not run in the image"
done
"${podman[@]}" image inspect localhost/evograsp:latest >image.json
jq -e '.[0].Healthcheck.Test' image.json >/dev/null || fail "the image has no health check"
[ "$(jq '.[0].Size' image.json)" -lt 300000000 ] || fail "the image has $(jq '.[0].Size' image.json) bytes"

# ---- the service ----
export DOCKER_HOST=unix://$folder/podman.sock COMPOSE_PROJECT_NAME=evograsp COMPOSE_HTTP_TIMEOUT=60
export EVOGRASP_CONFIG=quick EVOGRASP_PORT=18080
{
  printf 'version: "3.8"\nservices:\n  server:\n    environment:\n'
  for value in "${small[@]}"; do
    name=${value%%=*}
    name=${name^^}
    printf '      EVOGRASP_%s: "%s"\n' "${name//./__}" "${value#*=}"
  done
} >small.yml
# docker-compose is slow: while it works, the run is held.
compose up -d --no-build --scale worker=0 || fail "docker-compose up failed: $(tail -n 5 compose.log)"
tell() { inside curl -sf -d '' "http://127.0.0.1:$EVOGRASP_PORT/api/v1/$1" >/dev/null; }
within 60 tell pause || { fail "the server does not answer: $(compose logs; tail -n 5 compose.log)"; finish; }
compose up -d --no-build --scale worker=3 --no-recreate || fail "scaling failed: $(tail -n 5 compose.log)"
ask() { inside curl -sf "http://127.0.0.1:$EVOGRASP_PORT/api/v1/$1"; }
workers_are() { [ "$(ask workers | jq '[.workers[] | select(.state == "active")] | length')" = "$1" ]; }
within 90 workers_are 3 || fail "three workers do not join: $(ask workers)"

# Killed at work.
tell resume
at_work() { [ "$(ask workers | jq '[.workers[].tasks] | min')" -gt 0 ]; }
within 30 at_work || fail "not every worker gets work: $(ask workers)"
inside "${podman[@]}" kill evograsp_worker_2 >/dev/null 2>&1
tell pause || fail "the run was over before anything happened: raise run.generations"

# Podman leaves the timers of health checks to systemd; the checks themselves are asked here.
healthy() { inside "${podman[@]}" healthcheck run "$1" >>podman.log 2>&1; }
for name in evograsp_server_1 evograsp_worker_1; do healthy $name || fail "$name is not healthy"; done
inside "${podman[@]}" exec evograsp_server_1 evograsp status >status.txt 2>&1 || fail "status inside the container: $(cat status.txt)"
compose up -d --no-build --scale worker=4 --no-recreate || fail "scaling failed: $(tail -n 5 compose.log)"
within 90 workers_are 4 || fail "four workers after scaling are wanted: $(ask workers)"
compose restart --timeout 20 server || fail "the server does not restart: $(tail -n 5 compose.log)"
again() { [ "$(ask run | jq .epoch)" = 2 ]; }
within 60 again || fail "the server did not take its run up again: $(ask run)"
tell resume

finished() { [ "$(ask run | jq -r .state)" = finished ]; }
within 90 finished || fail "the run does not end: $(ask run)"
ask 'champion?format=pb' >champion.pb
cmp champion.pb local/champion.pb || fail "containers bred another champion"
finish
