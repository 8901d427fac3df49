//! Capability and size of an aircraft on the ground: I021/271.

use super::Edition;
use crate::item::{in_place, items};

/// Declares I021/271, whose first part is the same in all editions.
macro_rules! surface {
    ($(#[$doc:meta])* $form:ident $name:ident { $($last:tt)* }) => {
        items! {
            $(#[$doc])*
            $form pub struct $name {
                first {
                    spare 2 "spare";
                    /// POA: the position refers to the ADS-B reference point.
                    flag 1 "poa" is_reference_point / with_reference_point;
                    /// CDTI/S: the cockpit display of traffic information on the surface is operational.
                    flag 1 "cdtis" has_traffic_display / with_traffic_display;
                    /// B2 low: class B2, which transmits with less than 70 W.
                    flag 1 "b2low" is_low_power / with_low_power;
                    /// RAS: receives ATC services.
                    flag 1 "ras" receives_services / with_services;
                    /// IDENT: the switch is active.
                    flag 1 "ident" is_ident / with_ident;
                }
                last {
                    $($last)*
                }
            }
        }
    };
}

surface! {
    /// I021/271 from edition 2.2 on: one octet and, where sent, its extensions.
    extended SurfaceCharacteristics {
        /// LW, length and width as a code, 0 to 15; 0 if the extension is absent.
        count 4 "lw" length_and_width / with_length_and_width: u8;
        spare 3 "spare_2";
    }
}

surface! {
    /// I021/271 up to edition 2.1: one octet, and a second one without FX.
    parts SurfaceCharacteristics21 {
        spare 4 "spare_2";
        /// LW, length and width as a code, 0 to 15; 0 if the second octet is absent.
        count 4 "lw" length_and_width / with_length_and_width: u8;
    }
}

/// I021/271 in the layout of the edition of its sender.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surface {
    /// Layout up to edition 2.1.
    Edition21(SurfaceCharacteristics21),
    /// Layout from edition 2.2 on.
    Edition22(SurfaceCharacteristics),
}

in_place! {
    Surface (edition: Edition) reader => {
        Ok(match edition {
            Edition::V2_1 => Self::Edition21(SurfaceCharacteristics21::from_reader_with_ctx(reader, ())?),
            _ => Self::Edition22(SurfaceCharacteristics::from_reader_with_ctx(reader, ())?),
        })
    },
    self writer => match self {
        Self::Edition21(item) => item.to_writer(writer, ()),
        Self::Edition22(item) => item.to_writer(writer, ()),
    }
}

impl Surface {
    /// Its field reference number.
    pub(super) const FRN: u8 = 37;

    /// All bits 0, in the layout of this edition. Values are set in [`Surface::Edition21`] or [`Surface::Edition22`].
    pub fn new(edition: Edition) -> Self {
        match edition {
            Edition::V2_1 => Self::Edition21(SurfaceCharacteristics21::default()),
            _ => Self::Edition22(SurfaceCharacteristics::default()),
        }
    }

    /// LW, length and width as a code; 0 if it was not sent.
    pub const fn length_and_width(self) -> u8 {
        match self {
            Self::Edition21(item) => item.length_and_width(),
            Self::Edition22(item) => item.length_and_width(),
        }
    }

    /// Maximum length and width in metres for the code (ED-102A, table of aircraft lengths and widths); `None` for 0 (unknown).
    /// With code 15 the aircraft may be larger.
    pub fn largest_size_m(self) -> Option<(f64, f64)> {
        let sizes = [
            (15.0, 23.0),
            (25.0, 28.5),
            (25.0, 34.0),
            (35.0, 33.0),
            (35.0, 38.0),
            (45.0, 39.5),
            (45.0, 45.0),
            (55.0, 45.0),
            (55.0, 52.0),
            (65.0, 59.5),
            (65.0, 67.0),
            (75.0, 72.5),
            (75.0, 80.0),
            (85.0, 80.0),
            (85.0, 90.0),
        ];
        usize::from(self.length_and_width()).checked_sub(1).and_then(|code| sizes.get(code).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_octet_has_no_fx_in_edition_2_1() {
        let old = SurfaceCharacteristics21::default().with_ident(true).with_length_and_width(5).unwrap();
        assert_eq!(old.octets(), [0x03, 0x05]);
        assert!(old.is_ident() && !old.is_reference_point());
        let new = SurfaceCharacteristics::default().with_ident(true).with_length_and_width(5).unwrap();
        assert_eq!(new.chain().octets(), [0x03, 0x50]);
        assert_eq!(Surface::Edition21(old).length_and_width(), Surface::Edition22(new).length_and_width());
        assert_eq!(Surface::Edition22(new).largest_size_m(), Some((35.0, 38.0)));
        assert_eq!(Surface::new(Edition::V2_1).largest_size_m(), None);
        assert_eq!(SurfaceCharacteristics21::default().octets(), [0x00]);
    }
}
