#!/usr/bin/env bash
# Installs what evograsp needs on Debian 12. Idempotent: does nothing when all is there.
#   deploy/setup.sh          to build, test and run
#   deploy/setup.sh --test   also what the tests of platforms need (Slurm, containers, kubectl)
#   deploy/setup.sh --ci     also what the checks need (those tests, second compiler, linters, emulator)
#   deploy/setup.sh --runtime  only the shared libraries of finished binaries (containers)
#   deploy/setup.sh --list   prints the packages, one a line, and installs nothing
set -euo pipefail

build=(
  ca-certificates git g++ cmake ninja-build ccache pkg-config
  libprotobuf-dev protobuf-compiler libzmq3-dev cppzmq-dev libeigen3-dev libexpected-dev
  libbullet-dev libbullet-extras-dev libembree-dev libqhull-dev libassimp-dev liburdfdom-dev
  libspdlog-dev libcli11-dev libsqlite3-dev sqlite3 libzstd-dev libcpp-httplib-dev nlohmann-json3-dev
  prometheus-cpp-dev libpng-dev zlib1g-dev libcairo2-dev libsodium-dev fonts-dejavu-core
  libgtest-dev libgmock-dev libbenchmark-dev curl jq procps
)
# Engines that place processes, for the tests on them (tests/platforms/).
platforms=(
  slurm-wlm munge podman runc conmon netavark aardvark-dns iptables debootstrap docker-compose iproute2 nftables
  systemd kubernetes-client python3-yaml
)
ci=(clang clang-format clang-tidy libclang-rt-14-dev qemu-user shellcheck)
# Shared libraries of the binaries: what a machine needs that only runs them.
runtime=(
  libprotobuf32 libzmq5 libbullet3.24 libbullet-extras3.24 libembree3-3 libqhull-r8.0 libassimp5 liburdfdom-model3.0
  libspdlog1.10 libsqlite3-0 libzstd1 libsodium23 libcpp-httplib0.11 libprometheus-cpp-core1.0 libpng16-16 libcairo2
  fonts-dejavu-core
)

wanted=("${build[@]}")
list_only=false
for arg in "$@"; do
  case "$arg" in
    --test) wanted+=("${platforms[@]}") ;;
    --ci) wanted+=("${platforms[@]}" "${ci[@]}") ;;
    --runtime) wanted=("${runtime[@]}") ;;
    --list) list_only=true ;;
    *) echo "setup.sh: unknown option '$arg' (--test, --ci, --runtime, --list)" >&2; exit 2 ;;
  esac
done
if $list_only; then printf '%s\n' "${wanted[@]}"; exit 0; fi

is_installed() {
  # Others' packages of the same program exclude Debian's.
  if [ "$1" = kubernetes-client ] && command -v kubectl >/dev/null; then return 0; fi
  dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null | grep -qx installed
}

missing=()
for package in "${wanted[@]}"; do is_installed "$package" || missing+=("$package"); done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "setup.sh: run as root, or install by hand: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "setup.sh: installing ${#missing[@]} packages: ${missing[*]}" >&2
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
