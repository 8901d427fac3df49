//! How well the radar's registration is found: asked, and not measured yet.

use crate::asked::{Asked, Bound};

/// The rows of the table.
pub fn asked() -> Vec<Asked> {
    let row = |figure: &str, required, ambition| Asked {
        figure: figure.to_owned(),
        decimals: 2,
        required,
        ambition,
        reference: None,
        reached: None,
        at: None,
        why: "",
    };
    vec![
        row(
            "azimuth registration error after 15 drone-minutes, degrees",
            Bound::AtMost(0.35),
            Bound::Nothing,
        ),
        row(
            "azimuth registration error after 200 drone-minutes, degrees",
            Bound::AtMost(0.12),
            Bound::Nothing,
        ),
        row("NEES of the azimuth registration", Bound::Between(0.5, 1.5), Bound::Nothing),
    ]
}
