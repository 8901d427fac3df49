//! `[integrity]`.

use tables::kinds::{Kind, flag, named, number};
use tables::reader::Section;
use tables::section;
use tables::table::ByHand;
use tables::{names, written_by_name};

/// Kind of an integrity index: the logarithm of a likelihood ratio. Honest transponders stay below a few tens.
fn index() -> Kind<f64> {
    number("an index is at least 0, and at most 1000", |index| (0.0..=1000.0).contains(&index))
}

section! {
    /// Detection of transponders that report a false position or identity (docs/INTEGRITY.md). Not used by the `reference`
    /// profile.
    Integrity {
        /// Action on a transponder whose reports are false.
        action: Action = Action::Flag, named();
        /// Index above which an identity is suspect. The index is the natural logarithm of the likelihood ratio of a false to a
        /// true report, by radar.
        on: f64 = 8.5, index();
        /// Index below which an identity is no longer suspect; less than `on`.
        off: f64 = 2.0, index();
        /// Alert limit, in metres: an identity is verified once radar would have revealed any larger offset of its position.
        alert_limit_m: f64 = 100.0,
            number("an alert limit is above 0, and at most 10000 metres", |metres| metres > 0.0 && metres <= 1e4);
        /// Whether the published accuracy of a suspect or failed identity includes its estimated offset.
        accuracy: bool = true, flag();
        /// Whether a radar track that contradicts a suspect's position is published as an aircraft of its own, once it has lasted
        /// 2 s.
        show_twin: bool = true, flag();
        /// Whether suspect or failed identities are excluded from registration and from the association of other aircraft.
        protect: bool = true, flag();
    } by hand {}
}

names! {
    /// Action on a transponder whose reports are false.
    #[derive(Copy, Eq)]
    Action, "action" {
        /// Integrity is not evaluated.
        Off = "off",
        /// The track is flagged, and an alert is raised.
        Flag = "flag",
        /// The track is flagged and published at its reported position, separate from what radar sees.
        Split = "split",
    }
}
written_by_name!(Action);

/// Rejects keys that contradict each other.
impl ByHand for Integrity {
    fn more(&mut self, section: &mut Section<'_>) {
        if self.on <= self.off {
            section.contradict(
                &["on", "off"],
                "on is above off (by default 8.5 and 2), or a flag would come and go; raise on or lower off",
            );
        }
    }
}
