#!/bin/sh
# Signal K's NMEA 0183 parser takes position, course and speed of an RMC sentence that says it is void.
#
# Version:   @signalk/nmea0183-signalk 3.20.1 (node 20.20)
# Behaviour: RMC's status (A or V) and mode are not looked at; GLL with status V gives no position.
# Seen:      $GPRMC,120000.50,V,5700.0000,N,01000.0000,E,3.5,090.0,301126,,,N: position 57 N 10 E, 1.80 m/s, as with A;
#            $GPGLL,5700.0000,N,01000.0000,E,120000.50,V,N: none
# Expected:  none from either: by NMEA 0183 status V is a warning of the receiver, and mode N says that data are not
#            valid. Fields need not be empty then.
# Matters:   a receiver that has lost its satellites, as under water, may repeat its last position and speed with V. A
#            display then shows a vehicle that stays where it dived, and a planner has a speed that nobody measured.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
npm install --silent --no-audit --no-fund --prefix "$place" @signalk/nmea0183-signalk@3.20.1
cat >"$place/read.js" <<'END'
const Parser = require('@signalk/nmea0183-signalk')

const RMC = (status, mode) => `GPRMC,120000.50,${status},5700.0000,N,01000.0000,E,3.5,090.0,301126,,,${mode}`
const GLL = (status, mode) => `GPGLL,5700.0000,N,01000.0000,E,120000.50,${status},${mode}`

function read(sentence) {
  const sum = [...sentence].reduce((sum, letter) => sum ^ letter.charCodeAt(0), 0)
  const line = `$${sentence}*${sum.toString(16).toUpperCase().padStart(2, '0')}`
  const delta = new Parser({ validateChecksum: true }).parse(line)
  const values = (delta ? delta.updates : []).flatMap((update) => update.values)
  const named = (path) => (values.find((value) => value.path === path) || { value: null }).value
  return [named('navigation.position'), named('navigation.speedOverGround')]
}

const there = { latitude: 57, longitude: 10 }
const [position, speed] = read(RMC('A', 'A'))
const seen = JSON.stringify([read(RMC('V', 'N')), read(GLL('A', 'A')), read(GLL('V', 'N'))])
const before = JSON.stringify([[position, speed], [there, null], [null, null]])
const valid = JSON.stringify(position) === JSON.stringify(there) && Math.abs(speed - 1.8006) < 1e-3
const same = valid && seen === before
console.log(`${same ? 'as before' : 'changed'}: position and speed of RMC V, GLL A and GLL V: ${seen}`)
process.exit(same ? 0 : 1)
END
node "$place/read.js"
