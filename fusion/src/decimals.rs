//! Numbers as text, for what outlives a restart: decimal, separated by spaces, so that what is read is to the bit what was
//! written. (As JSON numbers they would be so only with serde_json's `float_roundtrip`; without it the last digit may differ.)

use serde::{Deserialize, Serialize};

/// Numbers in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(crate) struct Decimals(pub(crate) Vec<f64>);

/// Not so many finite numbers: how many there are, and how many belong there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WrongNumbers(pub(crate) usize, pub(crate) usize);

impl From<Decimals> for String {
    fn from(numbers: Decimals) -> Self {
        let texts: Vec<String> = numbers.0.iter().map(|number| format!("{number:?}")).collect();
        texts.join(" ")
    }
}

impl TryFrom<String> for Decimals {
    type Error = std::num::ParseFloatError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.split_whitespace().map(str::parse).collect::<Result<_, _>>().map(Self)
    }
}

impl Decimals {
    pub(crate) fn of<'a>(parts: impl IntoIterator<Item = &'a [f64]>) -> Self {
        Self(parts.into_iter().flatten().copied().collect())
    }

    pub(crate) fn checked<const COUNT: usize>(&self) -> Result<&[f64; COUNT], WrongNumbers> {
        let wrong = WrongNumbers(self.0.len(), COUNT);
        let numbers = <&[f64; COUNT]>::try_from(self.0.as_slice()).map_err(|_| wrong)?;
        if numbers.iter().all(|number| number.is_finite()) { Ok(numbers) } else { Err(wrong) }
    }
}
