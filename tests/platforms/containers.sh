# Podman with storage of its own in a network namespace of its own, and the image of the product in it. Sourced.
# What takes minutes (Debian's base, the runtime packages) is kept in $EVOGRASP_CACHE, for other clones as well.
# shellcheck shell=bash disable=SC2154
cache=${EVOGRASP_CACHE:-/var/cache/evograsp}
deploy=$here/../../deploy
space=evograsp-$$

containers_possible() {
  [ "$(id -u)" -eq 0 ] || { echo "needs root, for containers in a network namespace"; return 1; }
  local program
  for program in podman runc conmon debootstrap docker-compose ip nsenter; do
    command -v $program >/dev/null || { echo "needs $program: deploy/setup.sh --test"; return 1; }
  done
  grep -q cgroup /proc/self/mountinfo || { echo "needs cgroups mounted, for containers"; return 1; }
  ip netns add "$space" 2>/dev/null || { echo "may not make network namespaces"; return 1; }
  ip -n "$space" link set lo up
}

# `ip netns exec` would hide /sys/fs/cgroup.
inside() { nsenter --net="/run/netns/$space" "$@"; }

containers_up() {
  mkdir -p "$cache"
  cat >containers.conf <<'TEXT'
[engine]
cgroup_manager="cgroupfs"
events_logger="file"
runtime="runc"
[containers]
default_ulimits=["nofile=1024:1024","nproc=4096:4096"]
[network]
network_backend="netavark"
TEXT
  export CONTAINERS_CONF=$folder/containers.conf
  podman=(podman --root "$cache/podman" --runroot "$cache/podman-run" --tmpdir "$cache/podman-tmp" --storage-driver overlay)
  nsenter --net="/run/netns/$space" "${podman[@]}" system service --time 0 "unix://$folder/podman.sock" 2>service.log &
  service=$!
  within 60 test -S podman.sock
}

containers_down() {
  [ -z "${service:-}" ] || { kill "$service"; wait "$service"; } 2>/dev/null
  local mounted
  while read -r mounted; do umount "$mounted"; done < <(awk -v at="$(realpath "$cache")" 'index($2, at) == 1 {print $2}' /proc/mounts | sort -r)
  ip netns del "$space" 2>/dev/null
}

# A tree of Debian with the runtime packages, by the very steps of the Dockerfile, as an image named by what went in.
runtime_image() {
  local key tree
  key=$(cat <("$deploy/setup.sh" --runtime --list) "$deploy/image.sh" | sha256sum | cut -c1-12)
  runtime=localhost/evograsp-runtime:$key
  "${podman[@]}" image exists "$runtime" && return 0
  tree=$cache/tree.$$
  if [ ! -e "$cache/base.tar" ]; then
    debootstrap --variant=minbase --include=ca-certificates bookworm "$tree" http://deb.debian.org/debian >base.log || return 1
    tar -C "$tree" -cf "$cache/base.tar.$$" . && mv "$cache/base.tar.$$" "$cache/base.tar"
  else
    mkdir "$tree" && tar -C "$tree" -xf "$cache/base.tar"
  fi
  cp /etc/resolv.conf "$tree/etc/resolv.conf"
  install -D -t "$tree/tmp/deploy" "$deploy/setup.sh" "$deploy/image.sh"
  chroot "$tree" /tmp/deploy/image.sh runtime >runtime.log 2>&1 || { tail -n 5 runtime.log; return 1; }
  rm -r "$tree/tmp/deploy"
  tar -C "$tree" -c . | "${podman[@]}" import - "$runtime" >/dev/null 2>import.log || { tail -n 5 import.log; return 1; }
  rm -r "$tree"
}

# The Dockerfile's last stage on it, with the installed build.
product_image() {
  runtime_image || return 1
  cmake --install "$(dirname "$bin")" --strip --prefix "$folder/image/opt/evograsp" >install.log || return 1
  sed -n '/^FROM/h; /^FROM/!H; ${x;p}' "$deploy/Dockerfile" |
    sed -e "s|^FROM .*|FROM $runtime|" -e '/^COPY deploy/d; /^RUN/d; s/^COPY --from=build /COPY /' >image/Dockerfile
  "${podman[@]}" build --quiet --format docker --tag localhost/evograsp:latest image >image.id 2>image.log ||
    { tail -n 5 image.log; return 1; }
}
