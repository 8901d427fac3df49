// WGS 84 and the local east-north frame about the site's first radar, in metres.

const SEMI_MAJOR = 6378137;
const FLATTENING = 1 / 298.257223563;
const E2 = FLATTENING * (2 - FLATTENING);
const SEMI_MINOR = SEMI_MAJOR * (1 - FLATTENING);
const EP2 = E2 / (1 - E2);

/** @param {number} degrees */
const radians = (degrees) => (degrees * Math.PI) / 180;
/** @param {number} value */
const degrees = (value) => (value * 180) / Math.PI;

/** @param {number} lat @param {number} lng */
function earthCentred(lat, lng) {
  const phi = radians(lat);
  const lambda = radians(lng);
  const n = SEMI_MAJOR / Math.sqrt(1 - E2 * Math.sin(phi) ** 2);
  return [n * Math.cos(phi) * Math.cos(lambda), n * Math.cos(phi) * Math.sin(lambda), n * (1 - E2) * Math.sin(phi)];
}

/** East and north of an origin. Bearings are exact, and ranges within millimetres over tens of kilometres. */
export class Frame {
  /** @param {number} lat @param {number} lng @param {boolean} [isRadar] */
  constructor(lat, lng, isRadar = true) {
    this.isRadar = isRadar;
    this.lat = lat;
    this.lng = lng;
    this.origin = earthCentred(lat, lng);
    this.sinPhi = Math.sin(radians(lat));
    this.cosPhi = Math.cos(radians(lat));
    this.sinLambda = Math.sin(radians(lng));
    this.cosLambda = Math.cos(radians(lng));
  }

  /** [east, north] of a position. @param {number} lat @param {number} lng @returns {Point} */
  toLocal(lat, lng) {
    const point = earthCentred(lat, lng);
    const dx = point[0] - this.origin[0];
    const dy = point[1] - this.origin[1];
    const dz = point[2] - this.origin[2];
    const towards = this.cosLambda * dx + this.sinLambda * dy;
    return [-this.sinLambda * dx + this.cosLambda * dy, -this.sinPhi * towards + this.cosPhi * dz];
  }

  /**
   * [latitude, longitude] of a point in the frame, corrected for the ellipsoid's curvature below the tangent plane.
   * @param {number} x @param {number} y
   * @returns {Point}
   */
  toGeodetic(x, y) {
    const up = -(x * x + y * y) / (2 * SEMI_MAJOR);
    const towards = -this.sinPhi * y + this.cosPhi * up;
    const px = this.origin[0] - this.sinLambda * x + this.cosLambda * towards;
    const py = this.origin[1] + this.cosLambda * x + this.sinLambda * towards;
    const pz = this.origin[2] + this.cosPhi * y + this.sinPhi * up;
    const p = Math.hypot(px, py);
    const theta = Math.atan2(pz * SEMI_MAJOR, p * SEMI_MINOR);
    const phi = Math.atan2(pz + EP2 * SEMI_MINOR * Math.sin(theta) ** 3, p - E2 * SEMI_MAJOR * Math.cos(theta) ** 3);
    return [degrees(phi), degrees(Math.atan2(py, px))];
  }
}

/** Degrees from true north, 0 to 360. @param {number} x @param {number} y */
export const bearing = (x, y) => (degrees(Math.atan2(x, y)) + 360) % 360;
