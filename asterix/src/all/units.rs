//! Units: conversion from those of the specification, and suffixes of keys.

/// A unit of the specification, the suffix of keys, and factor and divisor for conversion: lengths to metres, speeds to metres
/// per second. Flight levels are unchanged.
const UNITS: &[(&str, &str, f64, f64)] = &[
    ("", "", 1.0, 1.0),
    ("%", "percent", 1.0, 1.0),
    ("ALTFL", "flight_level", 1.0, 1.0),
    ("FL", "flight_level", 1.0, 1.0),
    ("MHz", "mhz", 1.0, 1.0),
    ("Mach", "mach", 1.0, 1.0),
    ("NM", "m", 1852.0, 1.0),
    ("NM/s", "m_s", 1852.0, 1.0),
    ("dB", "db", 1.0, 1.0),
    ("dBm", "dbm", 1.0, 1.0),
    ("dBm²", "dbm2", 1.0, 1.0),
    ("dBµV", "dbuv", 1.0, 1.0),
    ("fs", "fs", 1.0, 1.0),
    ("ft", "m", 0.3048, 1.0),
    ("ft/min", "m_s", 0.3048, 60.0),
    ("hPa", "hpa", 1.0, 1.0),
    ("kt", "m_s", 1852.0, 3600.0),
    ("m", "m", 1.0, 1.0),
    ("m/s", "m_s", 1.0, 1.0),
    ("m/s²", "m_s2", 1.0, 1.0),
    ("mb", "hpa", 1.0, 1.0),
    ("ms", "ms", 1.0, 1.0),
    ("m²", "m2", 1.0, 1.0),
    ("ns", "ns", 1.0, 1.0),
    ("s", "s", 1.0, 1.0),
    ("°", "deg", 1.0, 1.0),
    ("°/s", "deg_s", 1.0, 1.0),
    ("°C", "c", 1.0, 1.0),
];

/// The suffix of keys for a unit of the specification, and the converted value of `count / of` such units.
pub(super) fn convert(unit: &str, count: f64, of: f64) -> Option<(&'static str, f64)> {
    let &(_, ending, factor, divisor) = UNITS.iter().find(|(theirs, ..)| *theirs == unit)?;
    Some((ending, count * factor / (of * divisor)))
}

/// The key of a field such as `RHO` with a suffix: `rho_m`. A field without a name is `value`, and `FL` is not repeated.
pub(super) fn key(name: &str, ending: &str) -> String {
    match (bare(name).as_str(), ending) {
        (name, "") => name.to_owned(),
        ("fl", "flight_level") => ending.to_owned(),
        ("", _) => format!("value_{ending}"),
        (name, _) => format!("{name}_{ending}"),
    }
}

/// A name of the specification in lower case, after the name of its group. `VAL`, the value after a validity bit, has the name of
/// its group.
pub(super) fn bare(name: &str) -> String {
    name.strip_suffix("/VAL").unwrap_or(name).replace('/', "_").to_lowercase()
}

/// Number of decimals with which rounding is at most a sixteenth of the LSB, or with which the LSB is exact if these are fewer.
pub(super) fn decimals(lsb: f64) -> u8 {
    let suffice = |decimals: &u8| {
        let scale = 10_f64.powi(i32::from(*decimals));
        let is_exact = ((lsb * scale).round() / scale / lsb - 1.0).abs() < 1e-12;
        is_exact || 1.0 / scale <= lsb / 8.0
    };
    (0..16).find(suffice).unwrap_or(16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_contain_names_and_units() {
        for (name, ending, expected) in [
            ("RHO", "m", "rho_m"),
            ("FL", "flight_level", "flight_level"),
            ("HGT", "flight_level", "hgt_flight_level"),
            ("", "m_s", "value_m_s"),
            ("", "", ""),
            ("AREA/EP", "", "area_ep"),
            ("AREA/VAL", "", "area"),
            ("TID/TTR", "m", "tid_ttr_m"),
        ] {
            assert_eq!(key(name, ending), expected);
        }
    }

    #[test]
    fn units_are_ours() {
        assert_eq!(convert("NM", 1.0, 256.0), Some(("m", 1852.0 / 256.0)));
        assert_eq!(convert("ft", 25.0, 1.0), Some(("m", 7.62)));
        assert_eq!(convert("ft/min", 25.0, 4.0), Some(("m_s", 6.25 * 0.3048 / 60.0)));
        assert_eq!(convert("furlong", 1.0, 1.0), None);
    }

    #[test]
    fn decimals_suffice_to_find_the_count() {
        for (lsb, expected) in [
            (1852.0 / 256.0, 1),
            (0.25, 2),
            (1.0, 0),
            (1.0 / 128.0, 4),
            (360.0 / 65536.0, 4),
            (25.0, 0),
            (0.1, 1),
        ] {
            assert_eq!(decimals(lsb), expected, "{lsb}");
        }
    }
}
