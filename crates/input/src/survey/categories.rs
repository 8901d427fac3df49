//! Names of categories.

/// EUROCONTROL's name of the category; `None` if it is not in this list.
pub(super) const fn name(category: u8) -> Option<&'static str> {
    Some(match category {
        1 => "monoradar target reports, old",
        2 => "monoradar service messages, old",
        4 => "safety net messages",
        7 => "directed interrogation",
        8 => "monoradar weather",
        9 => "multiradar weather",
        10 => "surface movement reports",
        11 => "A-SMGCS data",
        15 => "INCS target reports",
        16 => "INCS configuration",
        17 => "Mode S coordination",
        18 => "Mode S data link",
        19 => "multilateration status",
        20 => "multilateration target reports",
        21 => "ADS-B target reports",
        23 => "ADS-B station status",
        25 => "CNS/ATM system status",
        32 => "flight plan requests",
        34 => "monoradar service messages",
        48 => "monoradar target reports",
        62 => "system track data",
        63 => "sensor status",
        65 => "system status",
        129 => "UAS reports",
        150 => "flight plan data",
        205 => "radio direction finder reports",
        240 => "radar video",
        247 => "version numbers",
        _ => return None,
    })
}
