//! The ground itself: a village, a river, farms, woods, fields and an aerodrome, all invented.
//!
//! The scenarios fly about (1100, 1050), their radar stands at the origin, and their aerodrome is at (1100, -1500) with a runway
//! along 70°.

use crate::feature::{Feature, Place};
use crate::shapes::{apart, band, blob, chance, curve, distance_to, rectangle};
use crate::village::Village;

/// Middle of the aerodrome, and bearing of its runway, degrees, as in the scenarios.
const AERODROME: (Place, f64) = ([1100.0, -1500.0], 70.0);
/// Middle of the fields, and their reach, metres.
const FIELDS: (Place, f64) = ([1000.0, 400.0], 6200.0);

const RIVER: [Place; 18] = [
    [-11_000.0, 5300.0],
    [-7600.0, 4900.0],
    [-5600.0, 3900.0],
    [-4000.0, 3600.0],
    [-2700.0, 2700.0],
    [-1300.0, 2250.0],
    [-500.0, 2050.0],
    [200.0, 1690.0],
    [700.0, 1640.0],
    [1120.0, 1530.0],
    [1500.0, 1500.0],
    [1720.0, 1180.0],
    [2150.0, 980.0],
    [2900.0, 1150.0],
    [3900.0, 560.0],
    [5300.0, 700.0],
    [7400.0, -300.0],
    [11_000.0, -700.0],
];
const BROOK: [Place; 6] = [
    [-2500.0, -600.0],
    [-1500.0, 150.0],
    [-900.0, 1000.0],
    [-700.0, 1500.0],
    [-450.0, 1800.0],
    [-420.0, 2030.0],
];
const DITCH: [Place; 5] =
    [[2900.0, -900.0], [2500.0, -300.0], [2080.0, 120.0], [1900.0, 620.0], [2060.0, 1000.0]];

const HIGHWAY: [Place; 11] = [
    [-11_000.0, -8000.0],
    [-7000.0, -5000.0],
    [-4300.0, -3000.0],
    [-2300.0, -1350.0],
    [-1000.0, 60.0],
    [-250.0, 830.0],
    [330.0, 1330.0],
    [640.0, 1760.0],
    [1500.0, 2700.0],
    [4300.0, 4300.0],
    [10_500.0, 8300.0],
];
/// From the village past the showground and the aerodrome to the east.
const SOUTH_ROAD: [Place; 12] = [
    [330.0, 1330.0],
    [400.0, 1050.0],
    [440.0, 720.0],
    [560.0, 250.0],
    [480.0, -350.0],
    [180.0, -1000.0],
    [90.0, -1750.0],
    [450.0, -2240.0],
    [1300.0, -1960.0],
    [2400.0, -1560.0],
    [5200.0, -1700.0],
    [10_500.0, -3000.0],
];
const EAST_LANE: [Place; 9] = [
    [430.0, 760.0],
    [760.0, 640.0],
    [1120.0, 560.0],
    [1620.0, 500.0],
    [2200.0, 430.0],
    [2800.0, 300.0],
    [3500.0, -300.0],
    [4000.0, -1000.0],
    [4150.0, -1640.0],
];
const MILL_LANE: [Place; 6] = [
    [2800.0, 300.0],
    [3150.0, 800.0],
    [3560.0, 1600.0],
    [3900.0, 2700.0],
    [4100.0, 3500.0],
    [4300.0, 4300.0],
];
const NORTH_ROAD: [Place; 6] = [
    [-250.0, 830.0],
    [-900.0, 1900.0],
    [-1900.0, 3000.0],
    [-2300.0, 4400.0],
    [-3400.0, 6500.0],
    [-3600.0, 10_500.0],
];
const WEST_ROAD: [Place; 5] =
    [[-2300.0, -1350.0], [-3500.0, -700.0], [-5600.0, -300.0], [-8200.0, 600.0], [-11_000.0, 700.0]];
const FEN_ROAD: [Place; 5] =
    [[450.0, -2240.0], [300.0, -3200.0], [900.0, -4500.0], [800.0, -6800.0], [1700.0, -10_500.0]];
const RIDGE_ROAD: [Place; 5] =
    [[-4300.0, -3000.0], [-2400.0, -3500.0], [-900.0, -3900.0], [400.0, -3900.0], [2300.0, -4700.0]];

/// Tracks: to the radar, over the showground, to the river and back to the highway.
const TRACKS: [&[Place]; 7] = [
    &[[-560.0, 520.0], [-330.0, 330.0], [-110.0, 190.0], [0.0, 28.0]],
    &[[0.0, 28.0], [170.0, 60.0], [360.0, 190.0], [545.0, 300.0]],
    &[
        [760.0, 640.0],
        [880.0, 820.0],
        [1100.0, 1050.0],
        [1230.0, 1270.0],
        [1330.0, 1520.0],
        [1420.0, 1900.0],
        [1500.0, 2700.0],
    ],
    &[[400.0, 1050.0], [700.0, 1120.0], [1100.0, 1050.0], [1430.0, 900.0], [1780.0, 720.0], [2200.0, 430.0]],
    &[[1120.0, 560.0], [1240.0, 300.0], [1180.0, -50.0], [860.0, -240.0], [500.0, -300.0]],
    &[[-900.0, 1900.0], [-300.0, 1820.0], [330.0, 1560.0]],
    &[[3560.0, 1600.0], [2900.0, 1900.0], [2200.0, 2300.0], [1500.0, 2700.0]],
];

const VILLAGES: [Village; 9] = [
    Village { name: "Plotley", middle: [250.0, 1390.0], radius_m: 310.0 },
    Village { name: "Squitterby", middle: [2820.0, 300.0], radius_m: 360.0 },
    Village { name: "Slotham", middle: [-2300.0, -1350.0], radius_m: 330.0 },
    Village { name: "Lagby St. Kalman", middle: [4300.0, 4300.0], radius_m: 460.0 },
    Village { name: "Much Echoing", middle: [-1950.0, 3050.0], radius_m: 300.0 },
    Village { name: "Fusewell", middle: [900.0, -4500.0], radius_m: 380.0 },
    Village { name: "Nether Azimuth", middle: [-5600.0, -300.0], radius_m: 340.0 },
    Village { name: "Gatewick", middle: [5200.0, -1700.0], radius_m: 360.0 },
    Village { name: "Coasting", middle: [-2350.0, 4500.0], radius_m: 200.0 },
];

/// Woods: middle and radius, metres.
const WOODS: [(Place, f64); 24] = [
    ([1660.0, 760.0], 105.0),
    ([760.0, 1390.0], 90.0),
    ([1560.0, 1290.0], 70.0),
    ([610.0, 880.0], 60.0),
    ([1350.0, 60.0], 210.0),
    ([-330.0, -330.0], 170.0),
    ([-1450.0, 1250.0], 330.0),
    ([2250.0, 1750.0], 300.0),
    ([3300.0, 2700.0], 240.0),
    ([-700.0, -1350.0], 300.0),
    ([2500.0, -750.0], 180.0),
    ([-3000.0, 1500.0], 520.0),
    ([3400.0, -3000.0], 480.0),
    ([-1700.0, -2600.0], 280.0),
    ([5400.0, 2300.0], 560.0),
    ([200.0, 3500.0], 420.0),
    ([-4800.0, 5900.0], 700.0),
    ([-7000.0, -2300.0], 800.0),
    ([7600.0, 1900.0], 620.0),
    ([7300.0, -4300.0], 760.0),
    ([-2600.0, -6500.0], 820.0),
    ([2200.0, 7200.0], 900.0),
    ([-8300.0, 2600.0], 560.0),
    ([4200.0, -7300.0], 640.0),
];

/// Farms: name, middle, and bearing of their buildings, degrees.
const FARMS: [(&str, Place, f64); 7] = [
    ("Ghost Farm", [795.0, 600.0], 105.0),
    ("Weir Farm", [1440.0, 1640.0], 20.0),
    ("Old Clutter Farm", [2060.0, 620.0], 60.0),
    ("Hangar Farm", [-1180.0, 560.0], 45.0),
    ("Doppler's Barn", [2560.0, 2080.0], 110.0),
    ("Sidelobe Farm", [-860.0, -600.0], 45.0),
    ("Low Pass", [3560.0, -600.0], 130.0),
];

/// All features. Those of a layer do not overlap where they have one colour.
pub fn features() -> Vec<Feature> {
    let roads = roads();
    let river = curve(&RIVER);
    let mut features = fields(&river);
    features.extend((WOODS.iter().enumerate()).map(|(index, (middle, radius_m))| {
        Feature::area(
            "landcover",
            "wood",
            if *radius_m < 200.0 { 12 } else { 10 },
            blob(*middle, *radius_m, index as u64),
        )
    }));
    features.push(Feature::area("water", "river", 10, band(&river, 26.0, 77)));
    features.push(Feature::area("water", "lake", 12, blob([1330.0, 745.0], 58.0, 5)));
    features.push(Feature::area("water", "lake", 10, blob([3050.0, 1180.0], 130.0, 8)));
    for brook in [&BROOK[..], &DITCH[..]] {
        features.push(Feature::line("waterway", "stream", 12, curve(brook)));
    }
    for (index, village) in VILLAGES.iter().enumerate() {
        let own = [(25.0, 60.0), (100.0, -70.0), (160.0, 110.0)]
            .map(|(bearing, aside)| village.street(bearing + 40.0 * index as f64, aside));
        features
            .extend(own.iter().map(|street| Feature::line("transportation", "minor", 12, street.clone())));
        let near = |road: &&Vec<Place>| distance_to(road, village.middle) < village.radius_m;
        let streets: Vec<Vec<Place>> =
            roads.iter().map(|(_, road)| road).filter(near).cloned().chain(own).collect();
        features.extend(village.features(&streets, (index as u64) << 32));
    }
    features.extend(roads.into_iter().map(|(class, road)| {
        let zoom = if class == "primary" { 10 } else { 11 };
        Feature::line("transportation", class, zoom, road)
    }));
    features.extend(TRACKS.map(|track| Feature::line("transportation", "track", 12, curve(track))));
    features.extend(FARMS.iter().enumerate().flat_map(|(index, farm)| buildings(farm, index as u64)));
    // The radar's hut.
    features.push(Feature::area("building", "hut", 14, rectangle([16.0, -12.0], 9.0, 6.0, 40.0)));
    features.extend(aerodrome());
    features
}

/// Classes and lines of the roads.
fn roads() -> Vec<(&'static str, Vec<Place>)> {
    let roads: [(&str, &[Place]); 8] = [
        ("primary", &HIGHWAY),
        ("secondary", &SOUTH_ROAD),
        ("secondary", &NORTH_ROAD),
        ("secondary", &WEST_ROAD),
        ("minor", &EAST_LANE),
        ("minor", &MILL_LANE),
        ("minor", &FEN_ROAD),
        ("minor", &RIDGE_ROAD),
    ];
    roads.map(|(class, road)| (class, curve(road))).to_vec()
}

/// Fields: the cells of an irregular grid, each a little smaller than its cell, so that hedges remain. They thin out with the
/// distance.
fn fields(river: &[Place]) -> Vec<Feature> {
    let (middle, reach_m) = FIELDS;
    let corner = |column: i64, row: i64| -> Place {
        let key = ((column + 1000) * 4096 + row + 1000) as u64;
        let along = 330.0 * (column as f64 + 0.5 * (chance(key) - 0.5));
        let across = 260.0 * (row as f64 + 0.5 * (chance(key ^ 0xf00_0000) - 0.5));
        let (sin, cos) = 17.0_f64.to_radians().sin_cos();
        [middle[0] + along * cos - across * sin, middle[1] + along * sin + across * cos]
    };
    let mut fields = Vec::new();
    for (column, row) in (-30..30).flat_map(|column| (-30..30).map(move |row| (column, row))) {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, up)| corner(column + right, row + up));
        let centre = [0, 1].map(|axis| corners.iter().map(|place| place[axis]).sum::<f64>() / 4.0);
        let key = ((column + 1000) * 8192 + row + 1000) as u64 ^ 0xfee_0000;
        let thinning = (apart(centre, middle) / reach_m).powi(3);
        let is_built = VILLAGES.iter().any(|village| apart(centre, village.middle) < village.radius_m)
            || corners.iter().any(|corner| is_on_aerodrome(*corner));
        if is_built || chance(key) < thinning {
            continue;
        }
        let class = match chance(key ^ 0xbee) {
            _ if distance_to(river, centre) < 230.0 => "grass", // meadows along the river
            share if share < 0.5 => "farmland",
            share if share < 0.78 => "grass",
            _ => continue,
        };
        let ring = corners.map(|place| {
            let share = 5.5 / apart(place, centre);
            crate::shapes::between(place, centre, share)
        });
        fields.push(Feature::area("landcover", class, 12, ring.to_vec()));
    }
    fields
}

/// Name and buildings of a farm about its yard.
fn buildings((name, [x, y], bearing_deg): &(&'static str, Place, f64), key: u64) -> Vec<Feature> {
    let (east, north) = bearing_deg.to_radians().sin_cos();
    let at = |along: f64, across: f64| [x + along * east + across * north, y + along * north - across * east];
    let mut features: Vec<Feature> = [
        (0.0, 24.0, 34.0, 14.0),
        (-32.0, 0.0, 12.0, 30.0),
        (26.0, -12.0, 14.0, 11.0),
        (4.0, -26.0, 24.0, 10.0),
    ]
    .iter()
    .enumerate()
    .filter(|(index, _)| *index < 2 || chance(key * 8 + *index as u64) < 0.8)
    .map(|(_, &(along, across, length, width))| {
        Feature::area("building", "farm", 14, rectangle(at(along, across), length, width, *bearing_deg))
    })
    .collect();
    features.push(Feature::place("farm", name, 13, at(0.0, 0.0)));
    features
}

/// The place at a distance along the runway and to the right of its middle, metres.
fn by_runway(along_m: f64, right_m: f64) -> Place {
    let ([x, y], bearing_deg) = AERODROME;
    let (east, north) = bearing_deg.to_radians().sin_cos();
    [x + along_m * east + right_m * north, y + along_m * north - right_m * east]
}

/// Whether a place is on the ground that the aerodrome's vehicles use, or beside the runway.
fn is_on_aerodrome(place: Place) -> bool {
    let ([x, y], bearing_deg) = AERODROME;
    let (east, north) = bearing_deg.to_radians().sin_cos();
    let (dx, dy) = (place[0] - x, place[1] - y);
    let (along_m, right_m) = (dx * east + dy * north, dx * north - dy * east);
    along_m.abs() < 980.0 && (-250.0..480.0).contains(&right_m)
}

/// The aerodrome: its grass, the runway, taxiways and an apron with hangars, to the right of the runway.
fn aerodrome() -> Vec<Feature> {
    let bearing_deg = AERODROME.1;
    let ring = |places: &[(f64, f64)]| places.iter().map(|&(along, right)| by_runway(along, right)).collect();
    let line = |places: &[(f64, f64)]| Feature::line("aeroway", "taxiway", 12, ring(places));
    let mut features = vec![
        Feature::area(
            "landcover",
            "grass",
            11,
            ring(&[
                (-880.0, -120.0),
                (880.0, -120.0),
                (900.0, 60.0),
                (760.0, 390.0),
                (-760.0, 390.0),
                (-900.0, 60.0),
            ]),
        ),
        Feature::area("aeroway", "runway", 11, rectangle(by_runway(0.0, 0.0), 1500.0, 32.0, bearing_deg)),
        Feature::area("aeroway", "apron", 12, rectangle(by_runway(80.0, 245.0), 330.0, 90.0, bearing_deg)),
        line(&[(-740.0, 0.0), (-740.0, 90.0), (-690.0, 120.0), (690.0, 120.0), (740.0, 90.0), (740.0, 0.0)]),
        line(&[(0.0, 120.0), (0.0, 205.0)]),
        line(&[(160.0, 120.0), (160.0, 205.0)]),
        line(&[(-120.0, 0.0), (-60.0, 120.0)]),
        Feature::line("transportation", "service", 12, ring(&[(80.0, 290.0), (80.0, 400.0), (110.0, 480.0)])),
        Feature::place("aerodrome", "Track Aerodrome", 11, by_runway(-260.0, 235.0)),
    ];
    for along in [-50.0, 10.0, 70.0, 130.0, 190.0] {
        features.push(Feature::area(
            "building",
            "hangar",
            13,
            rectangle(by_runway(along, 312.0), 44.0, 34.0, bearing_deg),
        ));
    }
    features.push(Feature::area(
        "building",
        "tower",
        13,
        rectangle(by_runway(270.0, 240.0), 16.0, 16.0, bearing_deg),
    ));
    features
}
