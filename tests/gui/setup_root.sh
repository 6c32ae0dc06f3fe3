#!/usr/bin/env bash
# setup_root.sh ROOT [SUITE]: a Debian with its own windowed Blender in the folder ROOT, once. Needs root, apt and a Debian mirror.
# SUITE trixie (default): Blender 4.3.2, Python 3.13; sid: Blender 5.2, Python 3.14, a moving target.
# PyPI's bpy has no window and Debian 12's Blender is too old, so the window is tested in a chroot. About 1.3 GB, one minute.
set -euo pipefail
root=$1 suite=${2:-trixie}
mirror=${MIRROR:-http://deb.debian.org/debian}
# numpy, cattr and requests: Debian only recommends them, Blender's extension system needs them
packages="blender python3-numpy python3-cattr python3-requests xvfb xdotool imagemagick
          libgl1 libglx-mesa0 libgl1-mesa-dri libegl1 libegl-mesa0 libxi6"
[ -e "$root/.ready" ] && exit 0
[ "$(id -u)" = 0 ] || { echo "gui-test: needs root, because it installs a Blender with a window into a chroot" >&2; exit 1; }

export DEBIAN_FRONTEND=noninteractive
command -v debootstrap >/dev/null || { apt-get update -qq; apt-get install -y -qq --no-install-recommends debootstrap >/dev/null; }
mountpoint -q "$root/proc" 2>/dev/null && umount "$root/proc"
rm -rf "$root"; mkdir -p "$(dirname "$root")"
log=$root.log
echo "gui-test: Debian $suite into $root" >&2
debootstrap --variant=minbase "$suite" "$root" "$mirror" > "$log" 2>&1 || { tail -5 "$log" >&2; exit 1; }

printf '#!/bin/sh\nexit 101\n' > "$root/usr/sbin/policy-rc.d"; chmod +x "$root/usr/sbin/policy-rc.d"    # starts no services
printf 'force-unsafe-io\npath-exclude=/usr/share/doc/*\npath-exclude=/usr/share/man/*\npath-exclude=/usr/share/locale/*\n' \
  > "$root/etc/dpkg/dpkg.cfg.d/small"
printf 'APT::Install-Recommends "false";\nAcquire::Languages "none";\nAcquire::Check-Valid-Until "%s";\n' \
  "$([ "$suite" = sid ] && echo false || echo true)" > "$root/etc/apt/apt.conf.d/small"                  # sid's mirrors may lag
cp /etc/resolv.conf "$root/etc/resolv.conf"

mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT                                                                          # nothing stays mounted
echo "gui-test: Blender and a virtual screen" >&2
{ chroot "$root" apt-get update -qq && chroot "$root" apt-get install -y $packages; } >> "$log" 2>&1 || { tail -5 "$log" >&2; exit 1; }
ln -sf ../proc/self/mounts "$root/etc/mtab"
rm -rf "$root"/var/cache/apt/archives/*.deb "$root"/var/lib/apt/lists/*
chroot "$root" blender --version | head -1 > "$root/.ready"
