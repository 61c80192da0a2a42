#!/bin/sh
# Makes an authority and certificates for trying things out, and a key pair for tokens:
#
#   deploy/make_test_certificates.sh FOLDER [MISSION [AGENT...]]
#
# ca.pem               the authority; its key is ca.key
# store.pem worker.pem of the servers, for localhost, 127.0.0.1 and the hosts in HOSTS
#                      ("store.lan 10.0.0.5")
# AGENT.pem            of each robot (alpha and bravo) of the mission (lab)
# viewer.pem           of somebody who may look into the mission
# map_viewer.pem       of a map viewer, which looks into every mission, for the same hosts as the servers
# operator.pem         of somebody who may do everything in every mission, but upload
# token.pub            what servers check tokens with; corbslam token signs with token.key
#
# The key of X.pem is X.key. What is in the folder already stays as it is, so that a robot can be
# added later. Good for DAYS days (30). Nobody guards these keys: not for robots in the field.
set -eu

[ $# -ge 1 ] || { sed -n '2,18s/^# \{0,1\}//p' "$0" >&2; exit 2; }
folder=$1
mission=${2:-lab}
[ $# -le 2 ] || { shift 2; agents=$*; }
: "${agents:=alpha bravo}" "${HOSTS:=}" "${DAYS:=30}"

umask 077
mkdir -p "$folder"
cd "$folder"

# quietly COMMAND...: what it says is shown only where it fails.
quietly() {
  "$@" > log.tmp 2>&1 || { cat log.tmp >&2; exit 1; }
}

if [ ! -e ca.pem ]; then
  quietly openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days "$DAYS" \
    -subj "/CN=CORB-SLAM test authority" -addext "basicConstraints=critical,CA:TRUE,pathlen:0" \
    -addext "keyUsage=critical,keyCertSign,cRLSign" -keyout ca.key -out ca.tmp
  mv ca.tmp ca.pem
fi

# make NAME IDENTITY USAGE [ALTERNATIVE-NAMES]
make() {
  [ ! -e "$1.pem" ] || return 0
  {
    echo "basicConstraints=critical,CA:FALSE"
    echo "keyUsage=critical,digitalSignature"
    echo "extendedKeyUsage=$3"
    echo "subjectAltName=URI:corbslam:$2${4:-}"
  } > extensions.tmp
  quietly openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes \
    -subj "/O=CORB-SLAM test/CN=$1" -keyout "$1.key" -out request.tmp
  quietly openssl x509 -req -in request.tmp -CA ca.pem -CAkey ca.key -days "$DAYS" \
    -extfile extensions.tmp -out certificate.tmp
  mv certificate.tmp "$1.pem"
}

loopback=",DNS:localhost,IP:127.0.0.1,IP:::1"
hosts=$loopback
for host in $HOSTS; do
  case $host in
    *:*) hosts="$hosts,IP:$host" ;;
    *[!0-9.]*) hosts="$hosts,DNS:$host" ;;
    *) hosts="$hosts,IP:$host" ;;
  esac
done
# A map store is a client of its workers.
make store stores/main serverAuth,clientAuth "$hosts"
make worker workers/one serverAuth "$hosts"
for agent in $agents; do
  # And a server for other programs on the robot, but for no host that it could pretend to be.
  make "$agent" "missions/$mission/agents/$agent" clientAuth,serverAuth "$loopback"
done
make viewer "missions/$mission/viewers/viewer" clientAuth
# To the store a client, to browsers a server.
make map_viewer "missions/-/viewers/map_viewer" serverAuth,clientAuth "$hosts"
make operator "missions/-/operators/operator" clientAuth

if [ ! -e token.pub ]; then
  quietly openssl genpkey -algorithm ed25519 -out token.key
  quietly openssl pkey -in token.key -pubout -out token.tmp
  mv token.tmp token.pub
fi
rm -f -- *.tmp
