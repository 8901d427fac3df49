//! The engine's state as octets, and back. An engine that restores them publishes the same as the one that wrote them.
//!
//! | octets | |
//! |---|---|
//! | 8 | `utmckpt` and a zero |
//! | 2 | [`LAYOUT`], big endian like all numbers outside the state |
//! | 8 | hash of the settings |
//! | | the state in postcard |
//! | 8 | hash of all octets before |

use std::mem;
use std::num::NonZeroUsize;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::settings::{Profile, Settings};

/// First octets of every checkpoint.
const MAGIC: &[u8; 8] = b"utmckpt\0";

/// Version of the layout. Increment it whenever a type of the state, or the meaning of its numbers, changes. A test with a stored
/// checkpoint verifies this (`tests/engine/checkpoint.rs`).
pub(crate) const LAYOUT: u16 = 14;

/// Number of octets before the state.
const FRONT: usize = MAGIC.len() + size_of::<u16>() + size_of::<u64>();
/// Number of octets after the state.
const BACK: usize = size_of::<u64>();

/// Reason why octets are not restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointError {
    /// The octets do not begin with the mark of a checkpoint.
    #[error("not a checkpoint")]
    NotOne,
    /// The checkpoint has another layout: another version of the program wrote it.
    #[error("a checkpoint of layout {found}, and this version writes {LAYOUT}")]
    Layout {
        /// Layout of the checkpoint.
        found: u16,
    },
    /// The checkpoint is of an engine with other settings.
    #[error("a checkpoint of other settings")]
    Settings,
    /// The checkpoint is incomplete or damaged.
    #[error("a checkpoint that is damaged")]
    Damaged,
}

/// Appends the state of an engine with these settings to a buffer.
pub(crate) fn write(settings: &Settings, state: &impl Serialize, octets: &mut Vec<u8>) {
    let begin = octets.len();
    octets.extend(MAGIC);
    octets.extend(LAYOUT.to_be_bytes());
    octets.extend(of_settings(settings).to_be_bytes());
    *octets = postcard::to_extend(state, mem::take(octets)).expect("every state can be written down");
    let hash = hash(&octets[begin..]);
    octets.extend(hash.to_be_bytes());
}

/// Reads a state.
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

/// Hash of the settings, from their debug form, which shows every number in full. The number of threads is excluded, because it
/// does not change the output.
fn of_settings(settings: &Settings) -> u64 {
    let mut settings = settings.clone();
    if let Profile::Operational(rules) = &mut settings.profile {
        rules.threads = NonZeroUsize::MIN;
    }
    hash(format!("{settings:?}").as_bytes())
}

/// FNV-1a on eight octets at a time. It detects accidental damage, not manipulation.
fn hash(octets: &[u8]) -> u64 {
    let mix = |hash: u64, word: u64| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29);
    let (words, rest) = octets.as_chunks::<8>();
    let hash = words.iter().fold(0xcbf2_9ce4_8422_2325, |hash, word| mix(hash, u64::from_le_bytes(*word)));
    rest.iter().fold(mix(hash, rest.len() as u64), |hash, &octet| mix(hash, octet.into()))
}

/// Serialisation of arrays of any length; serde supports up to 32 elements, and no generic length.
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

/// Serialisation of rows of numbers.
pub(crate) mod rows {
    use serde::{Deserializer, Serializer};

    use super::array;

    /// A row that can be serialised.
    #[derive(serde::Serialize, serde::Deserialize)]
    struct NumberRow<const N: usize>(#[serde(with = "array")] [f64; N]);

    pub(crate) fn serialize<S: Serializer, const N: usize, const D: usize>(
        rows: &[[f64; N]; D],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        array::serialize(&rows.map(NumberRow), serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>, const N: usize, const R: usize>(
        deserializer: D,
    ) -> Result<[[f64; N]; R], D::Error> {
        array::deserialize(deserializer).map(|rows: [NumberRow<N>; R]| rows.map(|row| row.0))
    }
}
