use proptest::prelude::*;

use super::*;

fn place(latitude_deg: f64, longitude_deg: f64) -> Geodetic {
    Geodetic::from_degrees(latitude_deg, longitude_deg, 100.0)
}

fn named(name: &str) -> CellName {
    CellName::new(name).unwrap()
}

/// A position within the range of a grid, often exactly on an edge.
fn any_place() -> impl Strategy<Value = Geodetic> {
    let on_grid = |most: i32| (-most..most).prop_map(|tenth| f64::from(tenth) / 10.0);
    let latitude = prop_oneof![-84.9..84.9_f64, on_grid(849)];
    let longitude = prop_oneof![-180.0..180.0_f64, on_grid(1800)];
    (latitude, longitude).prop_map(|(latitude, longitude)| place(latitude, longitude))
}

/// Twelve cells that tile a rectangle; the inner corners are displaced.
fn any_tiles() -> impl Strategy<Value = Vec<(String, Vec<[f64; 2]>)>> {
    prop::collection::vec((-0.03..0.03_f64, -0.03..0.03_f64), 20).prop_map(|moved| {
        let corner = |row: usize, column: usize| {
            let is_inner = (1..3).contains(&row) && (1..4).contains(&column);
            let (east, north) = if is_inner { moved[row * 5 + column] } else { (0.0, 0.0) };
            [10.0 + 0.1 * column as f64 + east, 50.0 + 0.1 * row as f64 + north]
        };
        let tile = |row: usize, column: usize| {
            let ring = [(0, 0), (0, 1), (1, 1), (1, 0)];
            let ring = ring.map(|(up, right)| corner(row + up, column + right));
            (format!("t{row}{column}"), ring.to_vec())
        };
        (0..3)
            .flat_map(|row| (0..4).map(move |column| (row, column)))
            .map(|(row, column)| tile(row, column))
            .collect()
    })
}

proptest! {
    #[test]
    fn every_position_is_in_one_square(at in any_place(), step in prop_oneof![Just(0.05), Just(0.1), Just(0.25)]) {
        let territory = Territory::grid(step).unwrap();
        let own = territory.cell_of(at).unwrap();
        let outline = territory.outline(&own).unwrap();
        prop_assert!(outline.contains(at) && outline.distance_m(at) == 0.0);
        let others = territory.neighbours(&own, 10.0);
        // There are no cells beyond 85 degrees.
        let least = if at.latitude_deg().abs() < 85.0 - step { 7 } else { 5 };
        prop_assert!(others.len() >= least, "{others:?}");
        for other in others {
            prop_assert!(!territory.outline(&other).unwrap().contains(at), "{other} and {own}");
            prop_assert!(territory.neighbours(&other, 10.0).contains(&own), "{other} and {own}");
        }
    }

    #[test]
    fn every_position_is_in_one_polygon(tiles in any_tiles(), east in 0.001..0.399_f64, north in 0.001..0.299_f64) {
        let outlines: Vec<Outline> = tiles
            .iter()
            .map(|(_, ring)| Outline::new(ring.iter().map(|&[x, y]| Corner::of_degrees(x, y)).collect()).unwrap())
            .collect();
        let at = place(50.0 + north, 10.0 + east);
        prop_assert_eq!(outlines.iter().filter(|outline| outline.contains(at)).count(), 1);
        // A corner, too, belongs to exactly one cell.
        let [longitude, latitude] = tiles[5].1[0];
        prop_assert_eq!(outlines.iter().filter(|outline| outline.contains(place(latitude, longitude))).count(), 1);
        let territory = Territory::polygons(tiles).unwrap();
        let own = territory.cell_of(at).unwrap();
        prop_assert_eq!(territory.home(at, [&named("t00"), &own]), Some(own));
    }

    /// Distances agree with chords of the ellipsoid to 0.6 %, and to 2 % near 85 degrees, where meridians converge.
    #[test]
    fn margin_has_the_configured_width(at in any_place(), away_m in 1.0..3000.0_f64, azimuth in 0.0..std::f64::consts::TAU) {
        let territory = Territory::grid(0.1).unwrap();
        let outline = territory.outline(&territory.cell_of(at).unwrap()).unwrap();
        let plane = fusion::frames::TangentPlane::at_site(at);
        let moved = plane.to_geodetic(fusion::Enu::new(away_m * azimuth.sin(), away_m * azimuth.cos(), 0.0));
        let grown = outline.distance_m(moved);
        let most_m = away_m * if at.latitude_deg().abs() < 75.0 { 1.006 } else { 1.02 } + 0.01;
        prop_assert!(grown <= most_m, "{grown} m of {away_m}");
        prop_assert!(outline.is_within(moved, most_m));
        prop_assert_eq!(outline.is_within(moved, 0.0), outline.distance_m(moved) <= 0.0);
    }
}

#[test]
fn squares_are_named_by_their_south_west_corner() {
    let territory = Territory::grid(0.1).unwrap();
    for (latitude, longitude, name) in [
        (51.25, 4.37, "n512-e0043"),
        (51.2, 4.3, "n512-e0043"),
        (-0.01, -0.01, "s001-w0001"),
        (0.0, 0.0, "n000-e0000"),
        (52.5, -180.0, "n525-w1800"),
        (52.5, 180.0, "n525-w1800"),
        (52.5, 179.99, "n525-e1799"),
    ] {
        assert_eq!(territory.cell_of(place(latitude, longitude)), Some(named(name)));
    }
    // Across the antimeridian.
    let near = territory.neighbours(&named("n525-w1800"), 10.0);
    assert!(near.contains(&named("n525-e1799")) && near.contains(&named("n526-e1799")), "{near:?}");
    assert_eq!(near.len(), 8);
    for none in ["n512", "n0512-e0043", "x512-e0043", "n900-e0000", "n512-e1800"] {
        assert_eq!(territory.outline(&named(none)), None, "{none}");
    }
    assert_eq!(territory.cell_of(place(89.0, 4.0)), None);
}

#[test]
fn sensor_in_a_corner_is_used_by_all_four_cells() {
    let territory = Territory::grid(0.1).unwrap();
    let all = ["n524-w0006", "n524-w0007", "n525-w0006", "n525-w0007"].map(named);
    assert_eq!(territory.around(place(52.5, -0.6), 3000.0), all);
    assert_eq!(territory.around(place(52.55, -0.55), 1000.0), [all[2].clone()]);
    assert_eq!(territory.home(place(52.5, -0.6), &all), Some(all[2].clone()));
    // A position outside of all cells belongs to the nearest one.
    assert_eq!(territory.home(place(52.7, -0.55), &all), Some(all[2].clone()));
    assert_eq!(territory.home(place(52.5, -0.6), []), None);
}

#[test]
fn invalid_territory_is_refused_by_name() {
    assert_eq!(Territory::grid(0.3), Err(TerritoryError::Grid(0.3)));
    assert!(matches!(Territory::grid(0.5), Err(TerritoryError::Large { .. })));
    assert!(matches!(Territory::grid(f64::NAN), Err(TerritoryError::Grid(_))));
    let square = |x: f64, y: f64, side: f64| vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
    let of = |cells: &[(&str, Vec<[f64; 2]>)]| {
        Territory::polygons(cells.iter().map(|(name, ring)| ((*name).to_owned(), ring.clone())).collect())
    };
    let (a, b) = (named("a"), named("b"));
    assert!(of(&[("a", square(4.0, 51.0, 0.1)), ("b", square(4.1, 51.0, 0.1))]).is_ok());
    assert_eq!(
        of(&[("a", square(4.0, 51.0, 0.1)), ("b", square(4.05, 51.02, 0.1))]),
        Err(TerritoryError::Overlap(a.clone(), b.clone()))
    );
    // A polygon inside another one, and one on top of another one.
    for inner in [square(4.02, 51.02, 0.05), square(4.0, 51.0, 0.1)] {
        let both = of(&[("a", square(4.0, 51.0, 0.1)), ("b", inner)]);
        assert_eq!(both, Err(TerritoryError::Overlap(a.clone(), b.clone())));
    }
    assert_eq!(of(&[("a", vec![[4.0, 51.0], [4.1, 51.0]])]), Err(TerritoryError::Flat(a)));
    assert!(
        matches!(of(&[("b", square(4.0, 51.0, 0.9))]), Err(TerritoryError::Large { name, .. }) if name == b)
    );
    assert!(matches!(of(&[("North", square(4.0, 51.0, 0.1))]), Err(TerritoryError::Name(_))));
}
