//! Validity of a certificate, the only part that is read here (RFC 5280, 4.1.2.5).

use jiff::Timestamp;

use fusion::time::Time;

/// Validity period of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Validity {
    /// Start of the validity (`notBefore`).
    pub from: Time,
    /// End of the validity (`notAfter`).
    pub until: Time,
}

/// Tags of DER (X.690).
const INTEGER: u8 = 0x02;
const UTC_TIME: u8 = 0x17;
const GENERALIZED_TIME: u8 = 0x18;
const SEQUENCE: u8 = 0x30;
const VERSION: u8 = 0xa0;

impl Validity {
    /// Reads a certificate in DER; `None` if it is malformed.
    pub fn of(certificate: &[u8]) -> Option<Self> {
        let (certificate, _) = element(certificate, SEQUENCE)?;
        let (signed, _) = element(certificate, SEQUENCE)?;
        let rest = element(signed, VERSION).map_or(signed, |(_, rest)| rest);
        let (_, rest) = element(rest, INTEGER)?; // serial number
        let (_, rest) = element(rest, SEQUENCE)?; // signature algorithm
        let (_, rest) = element(rest, SEQUENCE)?; // issuer
        let (dates, _) = element(rest, SEQUENCE)?;
        let (from, rest) = time(dates)?;
        let (until, _) = time(rest)?;
        Some(Self { from, until })
    }
}

/// Content of the first element, which must have this tag, and the octets after it.
fn element(der: &[u8], tag: u8) -> Option<(&[u8], &[u8])> {
    let (&[found, length], rest) = der.split_first_chunk()?;
    let (length, rest) = match length {
        0..=0x7f => (usize::from(length), rest),
        0x81..=0x84 => {
            let (octets, rest) = rest.split_at_checked(usize::from(length & 0x7f))?;
            (octets.iter().fold(0, |length, &octet| length << 8 | usize::from(octet)), rest)
        }
        _ => return None,
    };
    (found == tag).then(|| rest.split_at_checked(length))?
}

/// Time `YYMMDDhhmmssZ` until 2049, `YYYYMMDDhhmmssZ` from 2050 on.
fn time(der: &[u8]) -> Option<(Time, &[u8])> {
    let utc = element(der, UTC_TIME);
    let (text, rest) = utc.or_else(|| element(der, GENERALIZED_TIME))?;
    let digits = str::from_utf8(text).ok()?.strip_suffix('Z').filter(|text| text.is_ascii())?;
    let (year, rest_of) = digits.split_at_checked(if utc.is_some() { 2 } else { 4 })?;
    let century = match (utc, year) {
        (None, _) => "",
        (Some(_), year) if year < "50" => "20",
        (Some(_), _) => "19",
    };
    let pairs: Vec<&str> = (0..5).map(|pair| rest_of.get(2 * pair..2 * pair + 2)).collect::<Option<_>>()?;
    let [month, day, hour, minute, second] = pairs[..] else { return None };
    let stamp: Timestamp = format!("{century}{year}-{month}-{day}T{hour}:{minute}:{second}Z").parse().ok()?;
    Some((Time::from_nanos(i64::try_from(stamp.as_nanosecond()).ok()?), rest))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rcgen::{CertificateParams, KeyPair, date_time_ymd};

    use super::*;

    fn certificate(from: (i32, u8, u8), until: (i32, u8, u8)) -> Vec<u8> {
        let mut params = CertificateParams::new(vec!["fusion.example".to_owned()]).unwrap();
        params.not_before = date_time_ymd(from.0, from.1, from.2);
        params.not_after = date_time_ymd(until.0, until.1, until.2);
        params.self_signed(&KeyPair::generate().unwrap()).unwrap().der().to_vec()
    }

    #[test]
    fn the_dates_of_a_certificate() {
        let Validity { from, until } = Validity::of(&certificate((2024, 2, 29), (2049, 12, 31))).unwrap();
        assert_eq!(
            (from.to_string(), until.to_string()),
            ("2024-02-29T00:00:00.000Z".to_owned(), "2049-12-31T00:00:00.000Z".to_owned())
        );
        // Written with all digits of the year.
        let Validity { from, until } = Validity::of(&certificate((1999, 1, 1), (2099, 1, 2))).unwrap();
        assert_eq!(
            (from.to_string(), until.to_string()),
            ("1999-01-01T00:00:00.000Z".to_owned(), "2099-01-02T00:00:00.000Z".to_owned())
        );
    }

    proptest! {
        #[test]
        fn arbitrary_octets_never_panic(octets in prop::collection::vec(any::<u8>(), 0..200), cut in 0..300usize) {
            let _ = Validity::of(&octets);
            let whole = certificate((2024, 1, 1), (2030, 1, 1));
            let _ = Validity::of(&whole[..cut.min(whole.len())]);
        }
    }
}
