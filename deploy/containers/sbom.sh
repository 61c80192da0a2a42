#!/bin/sh
# sbom.sh PACKAGES PROGRAM...: prints an SPDX 2.3 document of an image that holds the programs and
# (files of) the Debian packages that the file PACKAGES names, one a line, as this machine's dpkg
# knows them. SOURCE_DATE_EPOCH sets its date: then the same inputs give the same bytes.
set -eu

[ $# -ge 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
packages=$1
shift
version=$(sed -n 's/^project(corbslam VERSION \([0-9.]*\).*/\1/p' "$(dirname "$0")/../../CMakeLists.txt")
created=$(date -u -d "@${SOURCE_DATE_EPOCH:-$(date +%s)}" +%Y-%m-%dT%H:%M:%SZ)
# Names as they may stand in SPDX ids.
id() { printf %s "$1" | tr -c 'A-Za-z0-9.-' -; }

rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
while read -r package; do
  dpkg-query -W \
    -f '${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\t${Maintainer}\n' \
    "$package"
done < "$packages" > "$rows"
digest=$({ sha256sum < "$rows"; sha256sum "$@" | cut -d ' ' -f 1; } | sha256sum | cut -d ' ' -f 1)
name=corbslam-$(id "${1##*/}")-$version

cat <<HEAD
{
  "spdxVersion": "SPDX-2.3",
  "dataLicense": "CC0-1.0",
  "SPDXID": "SPDXRef-DOCUMENT",
  "name": "$name",
  "documentNamespace": "urn:corbslam:sbom:$name:$digest",
  "creationInfo": {"created": "$created", "creators": ["Tool: corbslam-sbom.sh"]},
  "packages": [
HEAD
for program in "$@"; do
  cat <<PROGRAM
    {"SPDXID": "SPDXRef-Program-$(id "${program##*/}")", "name": "${program##*/}",
     "versionInfo": "$version", "supplier": "Organization: CORB-SLAM",
     "downloadLocation": "NOASSERTION", "filesAnalyzed": false, "licenseConcluded": "Apache-2.0",
     "licenseDeclared": "Apache-2.0", "copyrightText": "NOASSERTION",
     "checksums": [{"algorithm": "SHA256",
                    "checksumValue": "$(sha256sum "$program" | cut -d ' ' -f 1)"}]},
PROGRAM
done
awk -F '\t' '
  function quoted(text) { gsub(/[\\"]/, "\\\\&", text); return "\"" text "\"" }
  # As the package URL specification wants versions.
  function encoded(text) { gsub(/:/, "%3A", text); gsub(/\+/, "%2B", text); return text }
  {
    before = NR == 1 ? "" : ",\n"
    spdx_id = $1
    gsub(/[^A-Za-z0-9.-]/, "-", spdx_id)
    maintainer = $6
    sub(/ *<.*/, "", maintainer)
    printf "%s    {\"SPDXID\": %s, \"name\": %s, \"versionInfo\": %s,\n", before,
           quoted("SPDXRef-Package-" spdx_id), quoted($1), quoted($2)
    printf "     \"supplier\": %s, \"sourceInfo\": %s,\n", quoted("Organization: " maintainer),
           quoted("built from " $4 " " $5)
    printf "     \"downloadLocation\": \"NOASSERTION\", \"filesAnalyzed\": false,\n"
    printf "     \"licenseConcluded\": \"NOASSERTION\", \"licenseDeclared\": \"NOASSERTION\",\n"
    printf "     \"copyrightText\": \"NOASSERTION\", \"externalRefs\": [\n"
    printf "       {\"referenceCategory\": \"PACKAGE-MANAGER\", \"referenceType\": \"purl\",\n"
    printf "        \"referenceLocator\": %s}]}",
           quoted("pkg:deb/debian/" encoded($1) "@" encoded($2) "?arch=" $3 "&distro=debian-12")
  }
  END { print "" }' "$rows"
echo '  ],'
echo '  "relationships": ['
separator=
for program in "$@"; do
  [ -z "$separator" ] || echo "$separator"
  separator='    ,'
  program_id=SPDXRef-Program-$(id "${program##*/}")
  cut -f 1 "$rows" | while read -r package; do
    echo "    {\"spdxElementId\": \"$program_id\", \"relationshipType\": \"DEPENDS_ON\"," \
      "\"relatedSpdxElement\": \"SPDXRef-Package-$(id "$package")\"},"
  done
  echo "    {\"spdxElementId\": \"SPDXRef-DOCUMENT\", \"relationshipType\": \"DESCRIBES\"," \
    "\"relatedSpdxElement\": \"$program_id\"}"
done
echo '  ]'
echo '}'
