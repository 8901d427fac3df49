//! Extended items: the names of the bits of each octet.

use asterix::Chain;
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::values::Hex;

/// The fields of one octet, name and bits, from bit 8 down to bit 2. What begins with `spare` is printed where it is not
/// zero; everything else always, so that the names say which extensions were sent.
type Octet = &'static [(&'static str, u8)];

/// I048/020, edition 1.32. `…_ep` is the element-populated bit of the value that follows it.
const TARGET_REPORT: &[Octet] = &[
    &[("typ", 3), ("sim", 1), ("rdp", 1), ("spi", 1), ("rab", 1)],
    &[("tst", 1), ("err", 1), ("xpp", 1), ("me", 1), ("mi", 1), ("foe_fri", 2)],
    &[("adsb_ep", 1), ("adsb", 1), ("scn_ep", 1), ("scn", 1), ("pai_ep", 1), ("pai", 1), ("spare_3", 1)],
    &[("acasxv_ep", 1), ("acasxv", 4), ("poxpr_ep", 1), ("poxpr", 1)],
    &[
        ("poact_ep", 1),
        ("poact", 1),
        ("dtfxpr_ep", 1),
        ("dtfxpr", 1),
        ("dtfact_ep", 1),
        ("dtfact", 1),
        ("spare_5", 1),
    ],
    &[("irmxpr_ep", 1), ("irmxpr", 1), ("irmact_ep", 1), ("irmact", 1), ("spare_6", 3)],
];

/// I048/170, edition 1.32.
const TRACK_STATUS: &[Octet] = &[
    &[("cnf", 1), ("rad", 2), ("dou", 1), ("mah", 1), ("cdm", 2)],
    &[("tre", 1), ("gho", 1), ("sup", 1), ("tcc", 1), ("spare_2", 3)],
];

/// An extended item as an object. Octets that no edition names follow as `more`, FX bits included.
pub(super) struct Fields {
    layout: &'static [Octet],
    chain: Chain,
}

impl Fields {
    /// I048/020.
    pub fn target_report(chain: Chain) -> Self {
        Self { layout: TARGET_REPORT, chain }
    }

    /// I048/170.
    pub fn track_status(chain: Chain) -> Self {
        Self { layout: TRACK_STATUS, chain }
    }
}

impl Serialize for Fields {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let octets = self.chain.octets();
        let mut object = serializer.serialize_map(None)?;
        for (fields, octet) in self.layout.iter().zip(octets) {
            let mut lowest = 8;
            for (name, width) in *fields {
                lowest -= width;
                let value = octet >> lowest & ((1 << width) - 1);
                if value != 0 || !name.starts_with("spare") {
                    object.serialize_entry(name, &value)?;
                }
            }
        }
        if let Some(more) = octets.get(self.layout.len()..).filter(|more| !more.is_empty()) {
            object.serialize_entry("more", &Hex::new(more))?;
        }
        object.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_fill_seven_bits() {
        for octet in TARGET_REPORT.iter().chain(TRACK_STATUS) {
            assert_eq!(octet.iter().map(|(_, width)| width).sum::<u8>(), 7, "{octet:?}");
        }
        let mut names: Vec<_> = TARGET_REPORT.iter().copied().flatten().map(|(name, _)| name).collect();
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }

    fn status(octets: &[u8]) -> String {
        let mut chain = Chain::new(0);
        for (index, &octet) in octets.iter().enumerate() {
            chain = chain.with(index, 0xfe, octet);
        }
        serde_json::to_string(&Fields::track_status(chain)).unwrap()
    }

    #[test]
    fn extensions_spare_bits_and_what_no_edition_names() {
        assert_eq!(status(&[0xa6]), r#"{"cnf":1,"rad":1,"dou":0,"mah":0,"cdm":3}"#);
        assert_eq!(
            status(&[0x18, 0x9a, 0, 0x42]),
            r#"{"cnf":0,"rad":0,"dou":1,"mah":1,"cdm":0,"tre":1,"gho":0,"sup":0,"tcc":1,"spare_2":5,"more":"0142"}"#
        );
    }
}
