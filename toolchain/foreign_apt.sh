# For `source`: foreign_apt ARCH FOLDER makes an apt state of its own in FOLDER for packages of another architecture: `main`
# of this machine's own mirror and release. Sets APT_CONFIG, which apt-get and apt-cache then follow; nothing of this
# machine's own package state changes.
foreign_apt() {
  local arch=$1 state=$2
  mkdir -p "$state"/{etc/apt.conf.d,lists/partial,cache/archives/partial,download}
  apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    awk '$2 == "bookworm" && $3 == "main" { print "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] " $1 " " $2 " " $3; exit }' >"$state/etc/sources.list"
  [ -s "$state/etc/sources.list" ] || { echo "this machine's apt knows no Debian 12 (bookworm main); run apt-get update first" >&2; return 1; }
  : >"$state/status"
  cat >"$state/apt.conf" <<CONF
APT::Architecture "$arch";
APT::Architectures { "$arch"; };
Dir::State "$state";
Dir::State::status "$state/status";
Dir::Cache "$state/cache";
Dir::Etc::sourcelist "$state/etc/sources.list";
Dir::Etc::sourceparts "/dev/null";
Acquire::Languages "none";
APT::Sandbox::User "root";
CONF
  export APT_CONFIG=$state/apt.conf
  apt-get update -q >"$state/log" 2>&1 || { tail -n 5 "$state/log" >&2; echo "apt-get update for $arch failed" >&2; return 1; }
}
