//! Accuracy and integrity of the position: I021/090.

use crate::item::items;

/// Metres in a nautical mile.
const NAUTICAL_MILE_M: f64 = 1852.0;

items! {
    /// VALSTATE in I021/090: result of an independent validation of the position.
    all pub enum ValidationState {
        /// 0: not done.
        NotDone,
        /// 1: done, without a result.
        NoResult,
        /// 2: passed.
        Passed,
        /// 3: failed.
        Failed,
    }

    /// I021/090, quality indicators: one octet and, where sent, its extensions (7 in edition 2.7; more are kept).
    ///
    /// Values of an absent extension are 0, which always means unknown or none.
    extended pub struct QualityIndicators {
        first {
            /// NUCr (version 0) or NACv: category of the velocity's accuracy.
            count 3 "nucr_nacv" velocity_category / with_velocity_category: u8;
            /// NUCp (version 0) or NIC: category of the position's uncertainty or integrity.
            count 4 "nucp_nic" position_category / with_position_category: u8;
        }
        extension {
            /// NICbaro: the barometric altitude has been cross-checked.
            flag 1 "nicbaro" is_altitude_checked / with_altitude_checked;
            /// SIL, integrity level, 0 to 3.
            count 2 "sil" integrity_level / with_integrity_level: u8;
            /// NACp, category of the position's accuracy, 0 to 11.
            count 4 "nacp" accuracy_category / with_accuracy_category: u8;
        }
        extension {
            spare 2 "spare_3";
            /// SILS: the integrity level is per sample; not set: per flight hour.
            flag 1 "sils" is_level_per_sample / with_level_per_sample;
            /// SDA, design assurance level, 0 to 3.
            count 2 "sda" design_assurance / with_design_assurance: u8;
            /// GVA, category of the geometric altitude's accuracy, 0 to 3.
            count 2 "gva" geometric_category / with_geometric_category: u8;
        }
        extension {
            /// PIC, position integrity category, 0 to 15.
            count 4 "pic" integrity_category / with_integrity_category: u8;
            /// SRC: the category was received and not derived; from edition 2.7 on.
            flag 1 "src" is_integrity_received / with_integrity_received;
            spare 2 "spare_4";
        }
        extension {
            spare 2 "spare_5";
            count 1 "valstate_ep";
            /// VALSTATE as a code of [`ValidationState`]; from edition 2.7 on.
            populated 2 "valstate" validation_code: u8;
            /// VD: the distance of the validation is given.
            flag 1 "vd" has_validation_distance;
            /// VQ: the quality of that distance is given.
            flag 1 "vq" has_validation_quality;
        }
        extension {
            unsigned 7 "valdistp1_m" = 128.0, 0;
        }
        extension {
            unsigned 7 "valdistp2_m" = 1.0, 0;
        }
        extension {
            unsigned 7 "valdistqualp1_m" = 128.0, 0;
        }
        extension {
            unsigned 7 "valdistqualp2_m" = 1.0, 0;
        }
    }
}

impl QualityIndicators {
    /// Radius around the position, in metres, that contains the aircraft with 95 % probability (EPU, RTCA DO-260B table 2-71), by
    /// NACp; `None` for 0 (unknown) and undefined codes. Version 0 has no NACp.
    pub fn horizontal_accuracy_m(&self) -> Option<f64> {
        Some(match self.accuracy_category() {
            1 => 10.0 * NAUTICAL_MILE_M,
            2 => 4.0 * NAUTICAL_MILE_M,
            3 => 2.0 * NAUTICAL_MILE_M,
            4 => NAUTICAL_MILE_M,
            5 => 0.5 * NAUTICAL_MILE_M,
            6 => 0.3 * NAUTICAL_MILE_M,
            7 => 0.1 * NAUTICAL_MILE_M,
            8 => 0.05 * NAUTICAL_MILE_M,
            9 => 30.0,
            10 => 10.0,
            11 => 3.0,
            _ => return None,
        })
    }

    /// Bound of the horizontal velocity's error, in metres per second, with 95 % probability, by NACv; `None` if unknown.
    pub fn velocity_accuracy_m_s(&self) -> Option<f64> {
        Some(match self.velocity_category() {
            1 => 10.0,
            2 => 3.0,
            3 => 1.0,
            4 => 0.3,
            _ => return None,
        })
    }

    /// Bound of the geometric altitude's error, in metres, with 95 % probability, by GVA (version 2); `None` if unknown.
    pub fn vertical_accuracy_m(&self) -> Option<f64> {
        match self.geometric_category() {
            1 => Some(150.0),
            2 => Some(45.0),
            _ => None,
        }
    }

    /// Result of a validation of the position; `None` if not populated.
    pub fn validation(&self) -> Option<ValidationState> {
        self.validation_code().map(ValidationState::from_code)
    }

    /// Distance of the position from its validation, in metres: LSB 1 m, 0 to 16,383 m.
    pub fn validation_distance_m(&self) -> Option<f64> {
        self.has_validation_distance().then(|| self.metres(5))
    }

    /// Accuracy of that distance, in metres: LSB 1 m, 0 to 16,383 m.
    pub fn validation_quality_m(&self) -> Option<f64> {
        self.has_validation_quality().then(|| self.metres(7))
    }

    /// The 14 bits in two octets that begin at the octet with this index.
    fn metres(&self, index: usize) -> f64 {
        let seven = |index| f64::from(self.chain().octet(index).unwrap_or(0) >> 1);
        seven(index) * 128.0 + seven(index + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Chain;

    #[test]
    fn accuracies() {
        let quality = QualityIndicators::default();
        assert_eq!(quality.horizontal_accuracy_m(), None);
        let quality = quality
            .with_accuracy_category(8)
            .and_then(|quality| quality.with_velocity_category(2))
            .and_then(|quality| quality.with_geometric_category(2))
            .unwrap();
        assert_eq!(quality.chain().octets(), [0x41, 0x11, 0x04]);
        assert_eq!(quality.horizontal_accuracy_m(), Some(0.05 * NAUTICAL_MILE_M));
        assert_eq!(quality.velocity_accuracy_m_s(), Some(3.0));
        assert_eq!(quality.vertical_accuracy_m(), Some(45.0));
        assert_eq!((quality.validation(), quality.validation_distance_m()), (None, None));
    }

    #[test]
    fn validation() {
        let chain = (0..3).fold(Chain::new(0), |chain, index| chain.with(index, 0, 0));
        let chain = chain.with(4, 0xff, 0x3c).with(5, 0xff, 0x04).with(6, 0xff, 0x06);
        let quality = QualityIndicators::from(chain);
        assert_eq!(quality.validation(), Some(ValidationState::Failed));
        assert_eq!(quality.validation_distance_m(), Some(2.0 * 128.0 + 3.0));
        assert_eq!(quality.validation_quality_m(), None);
    }
}
