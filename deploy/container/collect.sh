#!/usr/bin/env bash
# Puts programs, stripped, and the shared libraries that they need and a base image lacks into a folder, to be copied over that
# image.
#   deploy/container/collect.sh BASE_PACKAGES FOLDER PROGRAM...
# BASE_PACKAGES is a file with the base image's packages, one a line. Libraries bring the licence and the dpkg record of their
# package, the latter in /var/lib/dpkg/status.d, where scanners look for it.
set -euo pipefail
base_packages=$1 folder=$2
shift 2

# The package that a file belongs to. Packages still name /lib what Debian 12 has in /usr/lib.
package_of() {
  { dpkg-query -S "$1" || dpkg-query -S "${1#/usr}"; } 2>/dev/null | sed -n '1s/[:,].*//p'
}

mkdir -p "$folder/usr/local/bin" "$folder/var/lib/dpkg/status.d"
libraries=$(ldd "$@")
if grep 'not found' <<<"$libraries" >&2; then
  echo "collect: libraries are missing" >&2
  exit 1
fi
for program in "$@"; do
  strip -o "$folder/usr/local/bin/$(basename "$program")" "$program"
done

while read -r library; do
  file=$(readlink -f "$library")  # of an alternative: the chosen one
  package=$(package_of "$file")
  [ -n "$package" ] || { echo "collect: $file belongs to no package" >&2; exit 1; }
  ! grep -qx "$package" "$base_packages" || continue
  install -D -m 0644 "$file" "$folder/$(realpath "$(dirname "$library")")/$(basename "$library")"
  [ ! -e "$folder/var/lib/dpkg/status.d/$package" ] || continue
  dpkg-query -s "$package" >"$folder/var/lib/dpkg/status.d/$package"
  install -D -m 0644 "/usr/share/doc/$package/copyright" "$folder/usr/share/doc/$package/copyright"
done < <(sed -n 's/.*=> \(\/[^ ]*\) (.*/\1/p' <<<"$libraries" | sort -u)

# The authorities that --tls trusts; PostgreSQL is pointed to them by sslrootcert=/etc/ssl/certs/ca-certificates.crt.
install -D -m 0644 /etc/ssl/certs/ca-certificates.crt "$folder/etc/ssl/certs/ca-certificates.crt"
install -D -m 0644 LICENSE "$folder/usr/share/doc/cagefit/copyright"

echo "What the image adds to its base, in KiB:"
find "$folder" -type f -printf '%k %P\n' | sort -rn | sed -n 1,12p
du -sk --apparent-size "$folder"
