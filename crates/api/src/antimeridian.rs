//! Splitting of trails at the antimeridian, so that no part crosses it (RFC 7946, section 3.1.9).

use fusion::time::Time;
use service::history::HistoryTrack;

/// Parts of a trail. Each cut adds two places at the time of the crossing, one on either side.
pub fn cut(places: &[(Time, HistoryTrack)]) -> Vec<Vec<(Time, HistoryTrack)>> {
    let mut parts = vec![Vec::new()];
    for (index, (time, place)) in places.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| &places[before]);
        if let Some((ended, begun)) = before.and_then(|before| crossing(before, (*time, place))) {
            parts.last_mut().expect("a part").push(ended);
            parts.push(vec![begun]);
        }
        parts.last_mut().expect("a part").push((*time, place.clone()));
    }
    parts
}

/// Where the path between two places crosses the antimeridian: last place on one side and first place on the other.
fn crossing(
    (from_time, from): &(Time, HistoryTrack),
    (to_time, to): (Time, &HistoryTrack),
) -> Option<((Time, HistoryTrack), (Time, HistoryTrack))> {
    let apart = to.longitude_deg - from.longitude_deg;
    if apart.abs() <= 180.0 {
        return None;
    }
    // The shorter way around.
    let apart = apart - 360.0_f64.copysign(apart);
    let edge = 180.0_f64.copysign(apart);
    let share = (edge - from.longitude_deg) / apart;
    let between = |from: f64, to: f64| from + share * (to - from);
    let nanos = (to_time.nanos() - from_time.nanos()) as f64 * share;
    let time = Time::from_nanos(from_time.nanos() + nanos as i64);
    let ended = HistoryTrack {
        latitude_deg: between(from.latitude_deg, to.latitude_deg),
        longitude_deg: edge,
        altitude_amsl_m: from.altitude_amsl_m.zip(to.altitude_amsl_m).map(|(from, to)| between(from, to)),
        ..from.clone()
    };
    let begun = HistoryTrack { longitude_deg: -edge, ..ended.clone() };
    Some(((time, ended), (time, begun)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(
        second: i64,
        longitude_deg: f64,
        latitude_deg: f64,
        altitude_amsl_m: Option<f64>,
    ) -> (Time, HistoryTrack) {
        let place = HistoryTrack {
            id: "U-1".to_owned(),
            source: "radar",
            number: 1,
            latitude_deg,
            longitude_deg,
            altitude_amsl_m,
        };
        (Time::from_nanos(second * 1_000_000_000), place)
    }

    #[test]
    fn trail_across_antimeridian_is_split() {
        for side in [1.0, -1.0] {
            let trail = [
                place(0, side * 179.998, -17.0, Some(100.0)),
                place(1, side * 179.999, -17.0, Some(100.0)),
                place(5, side * -179.997, -17.04, Some(140.0)),
                place(6, side * -179.996, -17.05, None),
                place(7, side * 180.0, -17.05, None),
            ];
            let parts = cut(&trail);
            let lines: Vec<Vec<f64>> = parts
                .iter()
                .map(|part| part.iter().map(|(_, place)| place.longitude_deg * side).collect())
                .collect();
            let expected: [&[f64]; 3] =
                [&[179.998, 179.999, 180.0], &[-180.0, -179.997, -179.996, -180.0], &[180.0, 180.0]];
            assert_eq!(lines, expected);
            let (time, crossing) = &parts[0][2];
            assert_eq!(time.nanos(), 2_000_000_000);
            assert!((crossing.latitude_deg + 17.01).abs() < 1e-9);
            assert!((crossing.altitude_amsl_m.expect("a height") - 110.0).abs() < 1e-6);
            assert_eq!(parts[1][3].1.altitude_amsl_m, None);
        }
    }

    #[test]
    fn trail_elsewhere_is_not_split() {
        let trail = [place(0, -90.0, 10.0, None), place(1, 89.9, 10.0, None)];
        assert_eq!(cut(&trail), [trail.to_vec()]);
        assert_eq!(cut(&trail[..1]), [trail[..1].to_vec()]);
    }
}
