//! `classification` of a radar: how a plot states the probability that its target is an unmanned aircraft.

use tables::kinds::{Kind, Toml, list, named, number, whole};
use tables::names;
use tables::reader::Section;
use tables::table::Row;

names! {
    /// How a plot states its UAV probability.
    #[derive(Copy)]
    Classification, "source of probabilities" {
        /// Octet n of I048/SP, counted from 0 after the length octet, as a linear scale: offset + scale * value, within 0 to 1.
        SpecialPurpose(ScaledOctet) = "special-purpose",
        /// Octet of I048/SP that holds the radar's code for the kind of target. The probability is 0 for codes that are not of
        /// drones. For drones it is 1, or the probability that another octet states.
        SpecialPurposeCategory(CategoryOctet) = "special-purpose-category",
        /// Codes of I048/030: the probability is 0 for birds, vehicles, wind turbines and the like, otherwise 1.
        TargetClassification = "target-classification",
        /// The same probability for every plot.
        Constant {
            /// The probability, 0 to 1.
            value: f64
        } = "constant",
    }
}

/// Probability in an octet of I048/SP, on a linear scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaledOctet {
    /// Position of the octet, 0 to 253, counted after the length octet.
    pub octet: usize,
    /// Probability per count; `None` means 1 / 255.
    pub scale: Option<f64>,
    /// Probability at the count 0.
    pub offset: f64,
}

impl ScaledOctet {
    /// Probability that the contents of an I048/SP state; `None` if they end before the octet.
    pub fn probability(&self, contents: &[u8]) -> Option<f64> {
        let count = f64::from(*contents.get(self.octet)?);
        let scaled = self.scale.map_or(count / 255.0, |scale| scale * count);
        Some((self.offset + scaled).clamp(0.0, 1.0))
    }
}

/// Code of a kind of target in an octet of I048/SP.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CategoryOctet {
    /// Position of the octet, 0 to 253, counted after the length octet.
    pub octet: usize,
    /// Codes that mean a drone.
    pub drones: Codes,
    /// Where the probability of a drone is stated; `None` means 1.
    pub probability: Option<ScaledOctet>,
}

impl CategoryOctet {
    /// Probability that the contents of an I048/SP state; `None` if they end before a needed octet.
    pub fn probability(&self, contents: &[u8]) -> Option<f64> {
        match (self.drones.contains(*contents.get(self.octet)?), self.probability) {
            (false, _) => Some(0.0),
            (true, None) => Some(1.0),
            (true, Some(stated)) => stated.probability(contents),
        }
    }
}

/// Set of octet values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Codes([u128; 2]);

impl Codes {
    /// Whether the set contains `code`.
    pub fn contains(&self, code: u8) -> bool {
        self.0[usize::from(code >> 7)] >> (code & 0x7f) & 1 == 1
    }

    /// Codes of the set, in ascending order.
    pub fn iter(&self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(|code| self.contains(*code))
    }
}

impl FromIterator<u8> for Codes {
    fn from_iter<T: IntoIterator<Item = u8>>(codes: T) -> Self {
        let mut set = Self::default();
        codes.into_iter().for_each(|code| set.0[usize::from(code >> 7)] |= 1 << (code & 0x7f));
        set
    }
}

impl Classification {
    /// Linear scale on octet `octet` of I048/SP, 1/255 per count.
    pub const fn of_octet(octet: usize) -> Self {
        Self::SpecialPurpose(ScaledOctet { octet, scale: None, offset: 0.0 })
    }
}

fn octet_number() -> Kind<usize> {
    whole("octets of I048/SP are counted from 0 after the length, to 253", 0..=253)
}

fn probability() -> Kind<f64> {
    number("a probability is between 0 and 1", |v| (0.0..=1.0).contains(&v))
}

fn codes() -> Kind<Vec<u8>> {
    list(whole("codes are whole numbers from 0 to 255", 0..=255))
}

fn scale() -> Kind<f64> {
    number("a scale is between -1 and 1 and not 0", |v| v != 0.0 && (-1.0..=1.0).contains(&v))
}

fn offset() -> Kind<f64> {
    number("an offset is between -255 and 255", |v| (-255.0..=255.0).contains(&v))
}

/// Value of a key, if it is present and valid.
fn value<T>(section: &mut Section<'_>, key: &'static str, kind: &Kind<T>) -> Option<T> {
    section.item(key).and_then(|item| (kind.read)(&item))
}

fn scaled(section: &mut Section<'_>, octet: usize) -> ScaledOctet {
    let (scale, offset) = (value(section, "scale", &scale()), value(section, "offset", &offset()));
    ScaledOctet { octet, scale, offset: offset.unwrap_or(0.0) }
}

/// Kind of the key `classification`.
pub(super) fn probability_source() -> Kind<Classification> {
    Kind::new("a table of the keys below", |item| {
        let mut section = item.section()?;
        let source = section.need(
            "source",
            "source = \"special-purpose\", \"special-purpose-category\", \"target-classification\" or \"constant\"",
        );
        let mut read = source.and_then(|item| (named().read)(&item))?;
        match &mut read {
            Classification::SpecialPurpose(stated) => {
                let octet = value(&mut section, "octet", &octet_number()).unwrap_or(0);
                *stated = scaled(&mut section, octet);
            }
            Classification::SpecialPurposeCategory(category) => {
                category.octet = value(&mut section, "octet", &octet_number()).unwrap_or(0);
                let item = section.need("drones", "drones = [20], the radar's codes of drones");
                if let Some(item) = &item
                    && let Some(codes) = (codes().read)(item)
                {
                    if codes.is_empty() {
                        item.refuse("no target would be a drone; name the radar's codes of drones");
                    }
                    category.drones = codes.into_iter().collect();
                }
                category.probability = value(&mut section, "probability_octet", &octet_number())
                    .map(|octet| scaled(&mut section, octet));
            }
            Classification::TargetClassification => {}
            Classification::Constant { value } => {
                let item = section.need("value", "value = …, the probability from 0 to 1");
                *value = item.and_then(|item| (probability().read)(&item)).unwrap_or(0.0);
            }
        }
        section.finish();
        Some(read)
    })
}

impl Toml for ScaledOctet {
    /// Keys that follow `octet` in TOML.
    fn toml(&self) -> Option<String> {
        let scale = self.scale.map_or(String::new(), |scale| format!(", scale = {scale:?}"));
        let offset = if self.offset == 0.0 { String::new() } else { format!(", offset = {:?}", self.offset) };
        Some(scale + &offset)
    }
}

impl Toml for Classification {
    fn toml(&self) -> Option<String> {
        let more = match self {
            Self::SpecialPurpose(stated) => {
                format!(", octet = {}{}", stated.octet, stated.toml().unwrap_or_default())
            }
            Self::SpecialPurposeCategory(CategoryOctet { octet, drones, probability }) => {
                let drones = drones.iter().map(|code| code.to_string()).collect::<Vec<_>>().join(", ");
                let stated = probability.map_or(String::new(), |stated| {
                    format!(", probability_octet = {}{}", stated.octet, stated.toml().unwrap_or_default())
                });
                format!(", octet = {octet}, drones = [{drones}]{stated}")
            }
            Self::TargetClassification => String::new(),
            Self::Constant { value } => format!(", value = {value:?}"),
        };
        Some(format!("{{ source = \"{}\"{more} }}", self.name()))
    }

    fn keys() -> Vec<Row> {
        let source = named::<Self>().values;
        vec![
            Row::by_hand("source", None, &source, "Where the probability is stated."),
            Row::by_hand(
                "octet",
                Some("`0`"),
                &octet_number().values,
                "Octet of the probability with `source = \"special-purpose\"`, of the code with `\"special-purpose-category\"`.",
            ),
            Row::by_hand(
                "drones",
                None,
                &codes().values,
                "The radar's codes of drones; with `source = \"special-purpose-category\"`.",
            ),
            Row::by_hand(
                "probability_octet",
                Some("none, the probability is 1"),
                &octet_number().values,
                "Octet of the probability of targets with such a code; with `source = \"special-purpose-category\"`.",
            ),
            Row::by_hand(
                "scale",
                Some("1/255"),
                &scale().values,
                "Probability of one count of the octet that states it; `0.01` for per cent.",
            ),
            Row::by_hand(
                "offset",
                Some("`0.0`"),
                &offset().values,
                "Probability of the count 0 of that octet.",
            ),
            Row::by_hand(
                "value",
                None,
                &probability().values,
                "The probability; with `source = \"constant\"`.",
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I048/SP `04 01 14 46` from a drone radar: category 0x14, probability 70 %.
    const CONTENTS: [u8; 3] = [0x01, 0x14, 0x46];

    #[test]
    fn octet_is_scaled_and_kept_within_bounds() {
        let of = |scale, offset| ScaledOctet { octet: 2, scale, offset }.probability(&CONTENTS);
        assert_eq!(of(None, 0.0), Some(70.0 / 255.0));
        assert_eq!(of(Some(0.01), 0.0), Some(0.01 * 70.0));
        assert_eq!(of(Some(-0.01), 1.0).map(|p| (p * 1e9).round()), Some(0.3e9));
        assert_eq!([of(Some(1.0), 0.0), of(Some(0.01), -5.0)], [Some(1.0), Some(0.0)]);
        assert_eq!(ScaledOctet { octet: 3, ..Default::default() }.probability(&CONTENTS), None);
    }

    #[test]
    fn category_octet_with_separate_probability_octet() {
        let drones: Codes = [0x14, 0xff].into_iter().collect();
        let stated = ScaledOctet { octet: 2, scale: Some(0.01), offset: 0.0 };
        let category = CategoryOctet { octet: 1, drones, probability: Some(stated) };
        assert_eq!(category.probability(&CONTENTS), Some(0.01 * 70.0));
        assert_eq!(category.probability(&[1, 0x15, 0x46]), Some(0.0));
        assert_eq!(category.probability(&[1]), None);
        assert_eq!(CategoryOctet { probability: None, ..category }.probability(&[1, 255]), Some(1.0));
        assert_eq!(drones.iter().collect::<Vec<_>>(), [0x14, 0xff]);
    }
}
