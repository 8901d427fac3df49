//! Whether positions are inside, compared with shapely (testdata/oracle/zones.py). Skipped if that is not installed.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use utm_fusion::areas::{Areas, Masks};
use utm_fusion::config::{Area, AreaKind};

/// Total number of points.
const POINTS: usize = 100_000;

/// Rounds to the number of digits in files, so that both programs read the same number.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

/// A star with a hole about a position, in degrees.
fn polygon(random: &mut ChaCha8Rng) -> serde_json::Value {
    let centre = [random.random_range(-170.0..170.0), random.random_range(-75.0..75.0)];
    let corners = random.random_range(3..40);
    let shares: Vec<f64> = (0..corners).map(|_| random.random_range(0.3..1.0)).collect();
    let ring = |size: f64| {
        let corner = |number: usize| {
            let (sin, cos) = (std::f64::consts::TAU * number as f64 / corners as f64).sin_cos();
            let radius = size * shares[number % corners];
            [rounded(centre[0] + radius * cos), rounded(centre[1] + radius * sin)]
        };
        (0..=corners).map(corner).collect::<Vec<_>>()
    };
    serde_json::json!({ "type": "Polygon", "coordinates": [ring(0.1), ring(0.03)] })
}

#[test]
fn a_hundred_thousand_places_are_where_shapely_says() {
    let python = std::env::var("UTM_FUSION_SHAPELY").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/oracle/zones.py");
    let has_shapely = Command::new(&python).args(["-c", "import shapely"]).stderr(Stdio::null()).status();
    if !has_shapely.is_ok_and(|status| status.success()) {
        println!("skipped: {python} has no shapely; UTM_FUSION_SHAPELY names another interpreter");
        return;
    }
    let folder = std::env::temp_dir().join(format!("utm-fusion-zones-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(20);
    let (mut lines, mut ours) = (String::new(), Vec::new());
    for _ in 0..100 {
        let polygon = polygon(&mut random);
        let file = folder.join("polygon.geojson");
        std::fs::write(&file, polygon.to_string()).unwrap();
        let masks: Masks = Areas::load(&[Area { kind: AreaKind::Mask, file }]).unwrap().masks();
        let corners: Vec<[f64; 2]> = serde_json::from_value(polygon["coordinates"][0].clone()).unwrap();
        let places: Vec<[f64; 2]> = (0..POINTS / 100)
            .map(|number| {
                // Every tenth point is at a corner, where rounding decides, or next to one.
                let [x, y] = corners[random.random_range(0..corners.len())];
                match number % 10 {
                    0 => [x, y],
                    1 => [x + random.random_range(-1e-9..1e-9), y + random.random_range(-1e-9..1e-9)],
                    _ => [x + random.random_range(-0.12..0.12), y + random.random_range(-0.12..0.12)],
                }
            })
            .collect();
        ours.extend(places.iter().map(|place| masks.contain(place[0], place[1])));
        lines += &(serde_json::json!({ "polygon": polygon, "places": places }).to_string() + "\n");
    }
    std::fs::remove_dir_all(&folder).unwrap();

    let mut child =
        Command::new(&python).arg(script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || stdin.write_all(lines.as_bytes()).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success());
    let theirs: Vec<bool> = output
        .stdout
        .iter()
        .filter(|octet| !octet.is_ascii_whitespace())
        .map(|&octet| octet == b'1')
        .collect();
    assert_eq!(ours.len(), POINTS);
    assert_eq!(theirs.len(), POINTS);
    let differences = ours.iter().zip(&theirs).filter(|(ours, theirs)| ours != theirs).count();
    let inside = ours.iter().filter(|inside| **inside).count();
    println!("{POINTS} places, {inside} inside, {differences} differences");
    assert!(inside > POINTS / 10 && inside < POINTS * 9 / 10);
    assert_eq!(differences, 0);
}
