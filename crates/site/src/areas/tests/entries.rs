//! Times at which straight paths enter areas.

use geo::{Coord, Intersects, LineString, Point, Polygon};
use proptest::prelude::*;

use super::super::entry::time_to_entry;
use super::super::shape::Shape;
use super::super::zone::Volume;
use super::*;

/// Metres per degree of longitude and of latitude at the equator of the ellipsoid.
const EAST_M: f64 = 111_319.490_793;
const NORTH_M: f64 = 110_574.275_822;

fn shape(rings: &[&[[f64; 2]]]) -> Shape {
    let line =
        |ring: &&[[f64; 2]]| LineString::from(ring.iter().map(|&[x, y]| Coord { x, y }).collect::<Vec<_>>());
    let mut rings = rings.iter().map(line);
    Shape::new(Polygon::new(rings.next().unwrap(), rings.collect()).into()).unwrap()
}

/// A path from a position in degrees; velocity in m/s.
fn path(longitude_deg: f64, latitude_deg: f64, velocity: [f64; 3], altitude_m: Option<f64>) -> Path {
    let mut place = visitor(longitude_deg, latitude_deg, altitude_m).place;
    place.height_m = 0.0;
    Path::new(&place, velocity, altitude_m)
}

const EVERY_HEIGHT: BandAmsl = BandAmsl { floor_m: None, ceiling_m: None };

fn is_near(found: Option<f64>, expected_s: Option<f64>) {
    match (found, expected_s) {
        (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-4, "{found} {expected}"),
        _ => assert_eq!(found, expected_s),
    }
}

/// A square of 1 km side, 1 km east of the origin, with a hole from 200 m to 400 m east of its western edge.
fn square() -> Shape {
    let x = |metres: f64| metres / EAST_M;
    let y = |metres: f64| metres / NORTH_M;
    let ring = |west, south, east, north| {
        [
            [x(west), y(south)],
            [x(east), y(south)],
            [x(east), y(north)],
            [x(west), y(north)],
            [x(west), y(south)],
        ]
    };
    shape(&[&ring(1000.0, -500.0, 2000.0, 500.0), &ring(1200.0, -100.0, 1400.0, 100.0)])
}

#[test]
fn square_with_a_hole_excludes_the_hole() {
    let square = square();
    let time = |east_m: f64, north_m: f64, velocity: [f64; 3], horizon_s| {
        let path = path(east_m / EAST_M, north_m / NORTH_M, velocity, None);
        time_to_entry(&square, &EVERY_HEIGHT, &path, horizon_s)
    };
    is_near(time(0.0, 0.0, [20.0, 0.0, 0.0], 60.0), Some(50.0));
    is_near(time(0.0, 0.0, [20.0, 0.0, 0.0], 49.9), None);
    is_near(time(0.0, 0.0, [-20.0, 0.0, 0.0], 60.0), None);
    is_near(time(0.0, 0.0, [0.0, 0.0, 0.0], 60.0), None);
    is_near(time(0.0, 700.0, [20.0, 0.0, 0.0], 300.0), None);
    is_near(time(0.0, 700.0, [20.0, -4.0, 0.0], 300.0), Some(50.0));
    is_near(time(1500.0, 0.0, [20.0, 0.0, 0.0], 60.0), Some(0.0));
    // From the hole into the square.
    is_near(time(1300.0, 0.0, [10.0, 0.0, 0.0], 60.0), Some(10.0));
    is_near(time(1300.0, 0.0, [0.0, 0.0, 0.0], 60.0), None);
    // The path touches a corner; another path enters through a corner.
    is_near(time(500.0, 0.0, [10.0, 10.0, 0.0], 60.0), None);
    is_near(time(0.0, -1500.0, [10.0, 10.0, 0.0], 300.0), Some(100.0));
    // Parallel to an edge.
    is_near(time(0.0, 501.0, [20.0, 0.0, 0.0], 300.0), None);
}

#[test]
fn heights() {
    let square = square();
    let band = BandAmsl { floor_m: Some(100.0), ceiling_m: Some(120.0) };
    let time = |east_m: f64, east: f64, climb: f64, altitude_m| {
        let path = path(east_m / EAST_M, 0.0, [east, 0.0, climb], altitude_m);
        time_to_entry(&square, &band, &path, 60.0)
    };
    is_near(time(0.0, 20.0, 0.0, Some(110.0)), Some(50.0));
    is_near(time(0.0, 20.0, 0.0, Some(120.0)), Some(50.0));
    is_near(time(0.0, 20.0, 0.0, Some(90.0)), None);
    // Climbing into the band from below, climbing through it before the square, descending into it from above.
    is_near(time(0.0, 20.0, 1.0, Some(60.0)), Some(50.0));
    is_near(time(0.0, 20.0, 2.0, Some(10.0)), Some(50.0));
    is_near(time(0.0, 20.0, 2.0, Some(30.0)), None);
    is_near(time(1500.0, 0.0, 2.0, Some(50.0)), Some(25.0));
    is_near(time(1500.0, 1.0, -5.0, Some(170.0)), Some(10.0));
    is_near(time(1500.0, 0.0, -5.0, Some(90.0)), None);
    // Below the floor over the western part; the aircraft reaches the floor in the hole, and enters east of it.
    is_near(time(900.0, 10.0, 1.0, Some(65.0)), Some(50.0));
    // The altitude is unknown.
    is_near(time(0.0, 20.0, 3.0, None), Some(50.0));
}

#[test]
fn antimeridian_is_no_edge() {
    let east = shape(&[&[[179.9, -0.5], [180.0, -0.5], [180.0, 0.5], [179.9, 0.5], [179.9, -0.5]]]);
    let west = shape(&[&[[-180.0, -0.5], [-179.95, -0.5], [-179.95, 0.5], [-180.0, 0.5], [-180.0, -0.5]]]);
    let time = |shape: &Shape, longitude_deg, east| {
        let path = path(longitude_deg, 0.0, [east, 0.0, 0.0], None);
        assert!(path.reach(300.0).iter().any(|near| near.intersects(&shape.bounds)));
        time_to_entry(shape, &EVERY_HEIGHT, &path, 300.0)
    };
    let speed = 0.01 * EAST_M / 100.0;
    is_near(time(&west, 179.99, speed), Some(100.0));
    is_near(time(&east, 179.89, speed), Some(100.0));
    is_near(time(&east, -179.99, -speed), Some(100.0));
    is_near(time(&east, -179.99, speed), None);
    let circle = Shape::circle(179.999, 10.0, 1000.0).unwrap();
    assert_eq!(circle.polygon.0.len(), 2);
    assert!(circle.contains(&Point::new(-179.995, 10.0)) && circle.contains(&Point::new(179.995, 10.0)));
    assert!(!circle.contains(&Point::new(-179.985, 10.0)));
}

/// Positions inside a circle are inside its polygon; those outside by more than the polygon's excess are not.
#[test]
fn circle_has_its_radius_on_the_ellipsoid() {
    use geo::{Destination, Geodesic};
    for (longitude_deg, latitude_deg, radius_m) in
        [(10.0, 50.0, 3500.0), (-179.999, -17.0, 20_000.0), (0.0, 0.0, 5.0), (12.0, 84.0, 100_000.0)]
    {
        let circle = Shape::circle(longitude_deg, latitude_deg, radius_m).unwrap();
        for bearing_deg in 0..360 {
            let centre = Point::new(longitude_deg, latitude_deg);
            let at =
                |share: f64| Geodesic.destination(centre, f64::from(bearing_deg) + 0.3, radius_m * share);
            assert!(circle.contains(&at(0.9999)), "{latitude_deg} {radius_m} {bearing_deg}");
            assert!(!circle.contains(&at(1.0005)), "{latitude_deg} {radius_m} {bearing_deg}");
        }
    }
}

/// The length of a path in metres does not depend on the latitude.
#[test]
fn one_second_of_flight_has_the_right_length() {
    use geo::{Distance, Geodesic};
    for latitude_deg in [-60.0, 0.0, 47.0, 75.0_f64] {
        for velocity in [[30.0, 0.0, 0.0], [0.0, -30.0, 0.0], [18.0, 24.0, 0.0]] {
            let start = Point::new(10.0, latitude_deg);
            let east = shape(&[&[[10.0, -89.0], [11.0, -89.0], [11.0, 89.0], [10.0, 89.0], [10.0, -89.0]]]);
            let path = path(start.x(), start.y(), velocity, None);
            // From a point on the path itself.
            assert_eq!(time_to_entry(&east, &EVERY_HEIGHT, &path, 60.0), Some(0.0));
            let [lng, lat] = path.place_after(60.0);
            let flown_m = Geodesic.distance(start, Point::new(lng, lat));
            // Parallels are curved: in a minute at 75 degrees they deviate by just over a metre.
            assert!((flown_m - 1800.0).abs() < 2.0, "{latitude_deg} {flown_m}");
        }
    }
}

/// A polygon with corners clockwise at `shares` of 3 km from its centre, and a hole of half that size.
fn star(shares: &[f64], is_hollow: bool, (x, y): (f64, f64)) -> Shape {
    let ring = |size: f64| {
        let corner = |number: usize| {
            let (sin, cos) = (std::f64::consts::TAU * number as f64 / shares.len() as f64).sin_cos();
            let radius = size * shares[number % shares.len()];
            [(x + radius * cos) / EAST_M, (y + radius * sin) / NORTH_M]
        };
        (0..=shares.len()).map(corner).collect::<Vec<_>>()
    };
    let (outer, inner) = (ring(3000.0), ring(1500.0));
    if is_hollow { shape(&[&outer, &inner]) } else { shape(&[&outer]) }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// Compared with small steps along the path: no step before the entry is inside, and the position just after it is.
    #[test]
    fn entry_is_the_first_step_inside(
        shares in prop::collection::vec(0.2..1.0, 3..12),
        is_hollow in any::<bool>(),
        centre in (-3000.0..3000.0, -3000.0..3000.0),
        velocity in (-40.0..40.0, -40.0..40.0, -4.0..4.0),
        altitude_m in prop::option::of(0.0..300.0),
        band in (prop::option::of(50.0..150.0), prop::option::of(160.0..250.0)),
    ) {
        const STEP_S: f64 = 0.05;
        let star = star(&shares, is_hollow, centre);
        let band = BandAmsl { floor_m: band.0, ceiling_m: band.1 };
        let path = path(0.0, 0.0, [velocity.0, velocity.1, velocity.2], altitude_m);
        let is_inside = |seconds: f64| {
            let [lng, lat] = path.place_after(seconds);
            star.contains(&Point::new(lng, lat))
                && band.contains(altitude_m.map(|altitude_m| altitude_m + velocity.2 * seconds))
        };
        let first = (0..=1200).map(|step| f64::from(step) * STEP_S).find(|&seconds| is_inside(seconds));
        prop_assert!(first.is_none() || path.reach(60.0).iter().any(|near| near.intersects(&star.bounds)));
        match (time_to_entry(&star, &band, &path, 60.0), first) {
            (Some(entry_s), Some(first_s)) => {
                prop_assert!(entry_s <= first_s + 1e-9, "{entry_s} {first_s}");
                // The path may have crossed a corner between two steps.
                prop_assert!(is_inside(entry_s + 2e-6) || is_inside(entry_s), "{entry_s} is outside");
            }
            (Some(entry_s), None) => prop_assert!(is_inside(entry_s + 2e-6) || is_inside(entry_s), "{entry_s} is outside"),
            (None, first) => prop_assert_eq!(first, None),
        }
    }

    /// A path that starts later on the same line enters earlier by the time already flown.
    #[test]
    fn later_start_on_the_path_enters_earlier(
        shares in prop::collection::vec(0.2..1.0, 3..12),
        centre in (-3000.0..3000.0, -3000.0..3000.0),
        velocity in (-40.0..40.0, -40.0..40.0),
        share in 0.01..0.99,
    ) {
        let star = star(&shares, false, centre);
        let early = path(0.0, 0.0, [velocity.0, velocity.1, 0.0], None);
        if let Some(entry_s) = time_to_entry(&star, &EVERY_HEIGHT, &early, 60.0) {
            let [lng, lat] = early.place_after(entry_s * share);
            let late = path(lng, lat, [velocity.0, velocity.1, 0.0], None);
            let left_s = time_to_entry(&star, &EVERY_HEIGHT, &late, 60.0).unwrap();
            let error_s: f64 = left_s - entry_s * (1.0 - share);
            prop_assert!(error_s.abs() < 0.02, "{left_s} of {entry_s}");
        }
    }
}

/// The course is uncertain to both sides, and the flown part of the path does not count.
#[test]
fn earliest_entry_of_three_courses_is_used() {
    let x = |metres: f64| metres / EAST_M;
    // A diagonal edge from southwest to northeast, 1 km to the east.
    let wall = format!(
        r#"{{"type": "Polygon", "coordinates": [[[{}, -0.02], [0.1, -0.02], [0.1, 0.02], [{}, 0.02], [{}, -0.02]]]}}"#,
        x(1000.0) - 0.02,
        x(1000.0) + 0.02,
        x(1000.0) - 0.02,
    );
    let alerts = areas(&wall, &alert(|_| {})).alerts();
    let here = visitor(0.0, 0.0, None);
    let entry = |deviation: f64, flown_s: f64| {
        let path = path(0.0, 0.0, [20.0, 0.0, 0.0], None);
        let found = alerts.ahead(here, &path, deviation, flown_s, 0.0);
        assert_eq!(found.len(), 1);
        (found[0].time_s.unwrap(), found[0].earliest_s)
    };
    let (time_s, earliest_s) = entry(0.0, 0.0);
    assert!((time_s - 50.0).abs() < 0.01 && earliest_s == time_s, "{time_s}");
    // Turned right by 0.2 rad the path meets the diagonal edge after 1000 / (cos 0.2 + sin 0.2) metres.
    let (time_s, earliest_s) = entry(0.2, 0.0);
    let expected_s = 50.0 / (0.2_f64.cos() + 0.2_f64.sin() * NORTH_M / EAST_M);
    assert!(
        (time_s - 50.0).abs() < 0.01 && (earliest_s - expected_s).abs() < 0.1,
        "{earliest_s} {expected_s}"
    );
    let (time_s, earliest_s) = entry(0.0, 6.0);
    assert!((time_s - 44.0).abs() < 0.01 && earliest_s == time_s, "{time_s}");
}

/// Zones of one to three parts with different heights; several share a name.
fn any_zones() -> impl Strategy<Value = Vec<Zone>> {
    let shape = (prop::collection::vec(0.2..1.0, 3..9), any::<bool>(), (-9e3..9e3, -9e3..9e3), 0_usize..4);
    let part = (shape, prop::option::of(0.0..150.0), prop::option::of(100.0..300.0));
    let part = part.prop_map(|((shares, is_hollow, centre, place), floor_m, ceiling_m)| {
        // Most zones are near the aircraft; some are at the antimeridian, as are some aircraft.
        let longitude_deg = [0.0, 0.0, 179.88, -179.88][place];
        let shape = star(&shares, is_hollow, centre);
        let moved = geo::Translate::translate(&shape.polygon, longitude_deg, 0.0);
        Volume { shape: Shape::new(moved).unwrap(), band: Band::amsl(floor_m, ceiling_m) }
    });
    let zone = (prop::collection::vec(part, 1..4), 0_usize..20, prop::sample::select(&ZoneKind::ALL[..]));
    let zone = zone.prop_map(|(volumes, name, kind)| Zone {
        name: format!("zone {name}"),
        identifier: None,
        kind: Some(kind),
        conditions: None,
        schedule: Schedule::default(),
        format: Format::Ed318,
        volumes,
    });
    prop::collection::vec(zone, 0..40)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// The boxes change no result: checking every zone finds the same zones and entry times.
    #[test]
    fn bounding_boxes_change_no_result(
        zones in any_zones(),
        horizons in prop::collection::vec(0.0..200.0, 1..4),
        places in prop::collection::vec((-12e3..12e3_f64, -12e3..12e3, prop::sample::select(&[0.0_f64, 179.92, -179.92][..])), 20),
        altitude_m in prop::option::of(0.0..350.0),
        velocity in (-60.0..60.0, -60.0..60.0, -4.0..4.0),
        course_deviation in 0.0..0.5,
        flown_s in 0.0..10.0,
    ) {
        let settings: Vec<AlertArea> = horizons
            .iter()
            .map(|&horizon_s| AlertArea {
                predict_s: jiff::SignedDuration::from_secs_f64(horizon_s),
                ..AlertArea::default()
            })
            .collect();
        let alerts = AlertAreas::of(settings.iter().cycle().zip(&zones));
        let every = alerts.without_boxes();
        for (x, y, meridian_deg) in places {
            let longitude_deg = (meridian_deg + x / EAST_M + 180.0).rem_euclid(360.0) - 180.0;
            let visitor = visitor(longitude_deg, y / NORTH_M, altitude_m);
            let path = Path::new(&visitor.place, [velocity.0, velocity.1, velocity.2], altitude_m);
            let around = |areas: &AlertAreas| format!("{:?}", areas.around(visitor, 0.0));
            prop_assert_eq!(around(&alerts), around(&every));
            let ahead = |areas: &AlertAreas| format!("{:?}", areas.ahead(visitor, &path, course_deviation, flown_s, 0.0));
            prop_assert_eq!(ahead(&alerts), ahead(&every));
        }
    }
}
