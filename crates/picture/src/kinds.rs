//! Enumerations in the JSON of a track, with their names for the schema.

use fusion::Source;

/// Sources of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackSource {
    /// A radar track and a transponder.
    Fused,
    /// Radar only.
    Radar,
    /// Transponder only.
    Transponder,
    /// Cameras only, at least two.
    Camera,
}

// The history stores positions by the numbers of this order.
fusion::interface_names!(TrackSource {
    Fused = "fused",
    Radar = "radar",
    Transponder = "transponder",
    Camera = "camera",
});

impl From<&Source> for TrackSource {
    fn from(source: &Source) -> Self {
        match source {
            Source::Fused(..) => Self::Fused,
            Source::Radar(_) => Self::Radar,
            Source::Transponder(_) => Self::Transponder,
            Source::Cameras => Self::Camera,
        }
    }
}

/// State of a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrackState {
    /// Measured in this slot.
    Active,
    /// Not measured since; the position is extrapolated.
    Coasting,
}

fusion::interface_names!(TrackState { Active = "active", Coasting = "coasting" });

/// Kind of a sensor that contributed to a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContributorKind {
    /// A radar.
    Radar,
    /// A receiver of transponders, ADS-B or Remote ID.
    Transponder,
    /// A camera.
    Camera,
}

fusion::interface_names!(ContributorKind { Radar = "radar", Transponder = "transponder", Camera = "camera" });
