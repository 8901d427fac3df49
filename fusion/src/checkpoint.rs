//! The engine's state as octets, and back: who loads it and goes on publishes what the engine that wrote it would have.
//!
//! | octets | |
//! |---|---|
//! | 8 | `utmckpt` and a zero |
//! | 2 | [`LAYOUT`], big endian as all that follows but the state |
//! | 8 | hash of the settings |
//! | | the state, as postcard writes it |
//! | 8 | hash of all octets before |

use std::mem;
use std::num::NonZeroUsize;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::settings::{Profile, Settings};

/// What every checkpoint begins with.
const MAGIC: &[u8; 8] = b"utmckpt\0";

/// The layout of the state: one more whenever a type that belongs to it has changed, or what its numbers mean. A kept test
/// holds it to the types (`tests/engine/checkpoint.rs`).
pub(crate) const LAYOUT: u16 = 9;

/// Octets in front of the state.
const FRONT: usize = MAGIC.len() + size_of::<u16>() + size_of::<u64>();
/// And behind it.
const BACK: usize = size_of::<u64>();

/// Why octets are not taken for an engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// They do not begin as a checkpoint does.
    #[error("not a checkpoint")]
    NotOne,
    /// It is one of another layout: another version of the program wrote it.
    #[error("a checkpoint of layout {found}, and this version writes {LAYOUT}")]
    Layout {
        /// Its layout.
        found: u16,
    },
    /// It is one of an engine with other settings.
    #[error("a checkpoint of other settings")]
    Settings,
    /// It is not whole.
    #[error("a checkpoint that is damaged")]
    Damaged,
}

/// Writes a state of an engine with these settings behind what stands in a buffer.
pub(crate) fn write(settings: &Settings, state: &impl Serialize, octets: &mut Vec<u8>) {
    let begin = octets.len();
    octets.extend(MAGIC);
    octets.extend(LAYOUT.to_be_bytes());
    octets.extend(of_settings(settings).to_be_bytes());
    *octets = postcard::to_extend(state, mem::take(octets)).expect("every state can be written down");
    let hash = hash(&octets[begin..]);
    octets.extend(hash.to_be_bytes());
}

/// The state again.
pub(crate) fn read<T: DeserializeOwned>(settings: &Settings, octets: &[u8]) -> Result<T, CheckpointError> {
    let rest = octets.strip_prefix(MAGIC).ok_or(CheckpointError::NotOne)?;
    let (layout, _) = rest.split_first_chunk().ok_or(CheckpointError::Damaged)?;
    let found = u16::from_be_bytes(*layout);
    if found != LAYOUT {
        return Err(CheckpointError::Layout { found });
    }
    let (all, stated) = octets.split_last_chunk::<BACK>().ok_or(CheckpointError::Damaged)?;
    let state = all.get(FRONT..).ok_or(CheckpointError::Damaged)?;
    if hash(all) != u64::from_be_bytes(*stated) {
        return Err(CheckpointError::Damaged);
    }
    if all[FRONT - size_of::<u64>()..FRONT] != of_settings(settings).to_be_bytes() {
        return Err(CheckpointError::Settings);
    }
    match postcard::take_from_bytes(state) {
        Ok((state, [])) => Ok(state),
        Ok(_) | Err(_) => Err(CheckpointError::Damaged),
    }
}

/// Settings are the same where every number of them is: their debugging form shows each in full. With however many threads
/// the same is published.
fn of_settings(settings: &Settings) -> u64 {
    let mut settings = settings.clone();
    if let Profile::Operational(rules) = &mut settings.profile {
        rules.threads = NonZeroUsize::MIN;
    }
    hash(format!("{settings:?}").as_bytes())
}

/// FNV-1a, eight octets at a time: against accidents, not against anybody.
fn hash(octets: &[u8]) -> u64 {
    let mix = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
    let (words, rest) = octets.as_chunks::<8>();
    let hash = words.iter().fold(0xcbf2_9ce4_8422_2325, |hash, word| mix(hash, u64::from_le_bytes(*word)));
    rest.iter().fold(mix(hash, rest.len() as u64), |hash, &octet| mix(hash, octet.into()))
}

/// Arrays of any length, which serde knows up to 32 elements and not at all where the length is a parameter.
pub(crate) mod array {
    use std::fmt;
    use std::marker::PhantomData;

    use serde::de::{Error, SeqAccess, Visitor};
    use serde::ser::SerializeTuple;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer, T: Serialize, const N: usize>(
        array: &[T; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(N)?;
        array.iter().try_for_each(|element| tuple.serialize_element(element))?;
        tuple.end()
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[T; N], D::Error> {
        deserializer.deserialize_tuple(N, Elements(PhantomData))
    }

    struct Elements<T, const N: usize>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
        type Value = [T; N];

        fn expecting(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(text, "{N} elements")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<[T; N], A::Error> {
            let mut read = Vec::with_capacity(N);
            while let Some(element) = elements.next_element()? {
                read.push(element);
            }
            let count = read.len();
            read.try_into().map_err(|_| A::Error::invalid_length(count, &self))
        }
    }
}

/// Rows of numbers.
pub(crate) mod rows {
    use serde::{Deserializer, Serializer};

    use super::array;

    /// A row that knows how to be written.
    #[derive(serde::Serialize, serde::Deserialize)]
    struct Row<const N: usize>(#[serde(with = "array")] [f64; N]);

    pub(crate) fn serialize<S: Serializer, const N: usize, const D: usize>(
        rows: &[[f64; N]; D],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        array::serialize(&rows.map(Row), serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize, const R: usize>(
        deserializer: D,
    ) -> Result<[[f64; N]; R], D::Error> {
        array::deserialize(deserializer).map(|rows: [Row<N>; R]| rows.map(|row| row.0))
    }
}
