//! Precise times of reception of messages: I021/074, 076.

use crate::TimeOfDay;
use crate::item::items;

items! {
    /// FSI in I021/074 and 076: the whole second to which the fraction belongs.
    pub enum SecondIndication {
        /// that of the coarse time.
        Same = 0,
        /// the one after it.
        Next = 1,
        /// the one before it.
        Previous = 2,
    }

    /// I021/074 for the position and I021/076 for the velocity: fraction of the second in which the message was received, for use
    /// with I021/073 or 075.
    pub struct PreciseTime(4) {
        /// FSI, the whole second to which the fraction belongs.
        code 2 "fsi" second / with_second: SecondIndication;
        /// The fraction in seconds: LSB 2^-30 s (0.93 ns), 0 to below 1 s.
        unsigned 30 "tomrp_s" fraction_s / with_fraction_s = 1.0 / 1_073_741_824.0, 10;
    }
}

impl PreciseTime {
    /// Seconds since midnight, given the coarse time of the same message; -1 to 86,401 s around midnight. `None` for an undefined
    /// FSI.
    pub fn seconds(self, coarse: TimeOfDay) -> Option<f64> {
        let whole = f64::from(coarse.count() / TimeOfDay::PER_SECOND);
        let shift = match self.second() {
            SecondIndication::Same => 0.0,
            SecondIndication::Next => 1.0,
            SecondIndication::Previous => -1.0,
            SecondIndication::Other(_) => return None,
        };
        Some(whole + shift + self.fraction_s())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fraction_belongs_to_a_second() {
        let coarse = TimeOfDay::from_seconds(36_000.992_187_5).unwrap();
        let precise = PreciseTime::default().with_fraction_s(0.25).unwrap();
        assert_eq!(precise.octets(), [0x10, 0, 0, 0]);
        assert_eq!(precise.seconds(coarse), Some(36_000.25));
        assert_eq!(precise.with_second(SecondIndication::Next).seconds(coarse), Some(36_001.25));
        assert_eq!(precise.with_second(SecondIndication::Previous).seconds(coarse), Some(35_999.25));
        assert_eq!(precise.with_second(SecondIndication::Other(3)).seconds(coarse), None);
    }
}
