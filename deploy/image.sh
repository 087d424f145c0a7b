#!/usr/bin/env bash
# The steps that make a container image, on Debian 12. The Dockerfile runs them, and so does the test of the image.
#   deploy/image.sh build PREFIX   from the sources around this file: packages, build, installation under PREFIX
#   deploy/image.sh runtime        what the finished image needs beside PREFIX's files: libraries, user, /runs
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)

build() {
  "$here/setup.sh"
  cd "$here/.."
  cmake --preset release -DEVOGRASP_TESTS=OFF -DEVOGRASP_BENCH=OFF
  cmake --build --preset release --parallel
  cmake --install build/release --strip --prefix "$1"
}

# A fixed number, so that volumes and Kubernetes' runAsUser agree with the image.
user_id=10001

runtime() {
  "$here/setup.sh" --runtime
  apt-get clean
  rm -rf /var/lib/apt/lists/* /var/cache/debconf/*-old /var/log/apt /var/log/dpkg.log /usr/share/doc /usr/share/man \
    /usr/share/locale
  useradd --no-log-init --uid $user_id --no-create-home --home-dir /runs --shell /usr/sbin/nologin evograsp
  install -d -o evograsp -g evograsp -m 755 /runs
}

case ${1:-} in
  build) build "${2:?image.sh build: PREFIX is wanted}" ;;
  runtime) runtime ;;
  *) sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
esac
