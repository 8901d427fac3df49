//! Positions on Earth and the offset between two of them.

use fusion::frames::Geodetic;

/// Latitude, longitude and, if known, height above mean sea level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodeticPlace {
    /// WGS-84 latitude, degrees, north positive.
    pub latitude_deg: f64,
    /// WGS-84 longitude, degrees, east positive.
    pub longitude_deg: f64,
    /// Height above mean sea level, metres.
    pub altitude_amsl_m: Option<f64>,
}

/// Offset between two nearby places, along parallel, meridian and vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalOffset {
    /// Metres east.
    pub east_m: f64,
    /// Metres north.
    pub north_m: f64,
    /// Metres up; `None` if one of the heights is unknown.
    pub up_m: Option<f64>,
}

impl GeodeticPlace {
    /// Offset of `self` from `from`: differences of latitude and longitude times the WGS-84 radii of curvature at
    /// `from`. Away from the poles and below one kilometre, the error is at most 2 mm.
    pub fn offset_from(&self, from: &Self) -> LocalOffset {
        let ground = Geodetic::from_degrees(
            from.latitude_deg,
            from.longitude_deg,
            from.altitude_amsl_m.unwrap_or(0.0),
        );
        let east_deg = (self.longitude_deg - from.longitude_deg + 180.0).rem_euclid(360.0) - 180.0;
        let (meridian_m, prime_vertical_m) = ground.curvature_m();
        let middle = (0.5 * (self.latitude_deg + from.latitude_deg)).to_radians();
        LocalOffset {
            east_m: east_deg.to_radians() * (prime_vertical_m + ground.height_m) * middle.cos(),
            north_m: (self.latitude_deg - from.latitude_deg).to_radians() * (meridian_m + ground.height_m),
            up_m: self.altitude_amsl_m.zip(from.altitude_amsl_m).map(|(to, from)| to - from),
        }
    }
}

impl LocalOffset {
    /// Horizontal distance, metres (ePosH, equation 2 of the paper).
    pub fn horizontal_m(&self) -> f64 {
        self.east_m.hypot(self.north_m)
    }

    /// Vertical distance, metres (ePosV, equation 3 of the paper); `None` without heights.
    pub fn vertical_m(&self) -> Option<f64> {
        self.up_m.map(f64::abs)
    }

    /// Distance, metres (ePos, equation 1 of the paper); horizontal if a height is unknown.
    pub fn distance_m(&self) -> f64 {
        self.horizontal_m().hypot(self.up_m.unwrap_or(0.0))
    }
}
