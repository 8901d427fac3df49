//! Numbers as text, for saved state: decimal and separated by spaces, so that they are read back bit for bit. JSON
//! numbers would be exact only with serde_json's `float_roundtrip`; without it the last digit may differ.

use serde::{Deserialize, Serialize};

/// Numbers in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(crate) struct Decimals(pub(crate) Vec<f64>);

/// A list with a wrong number of values, or values that are not finite: the number of values, and the number expected.
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
