//! What goes to the sinks: a picture a second.

use std::sync::Arc;

use crate::config::PictureKind;
use crate::live::{Hub, Level, PublishedPicture};
use crate::picture::{Picture, PictureMaker, PictureTrack};
use fusion::time::Time;

/// A second's picture, and what a receiver has to know with it.
#[derive(Clone, Debug)]
pub struct Second {
    /// Names the tracks.
    pub maker: Arc<PictureMaker>,
    /// When it was due: the time at which it is published.
    pub due: Time,
    /// Which of both pictures it is.
    pub kind: PictureKind,
    /// Whether the service knows that something is wrong with itself or its sensors.
    pub level: Level,
    shown: Shown,
    max_accuracy_m: f64,
}

/// A picture is kept, not copied.
#[derive(Clone, Debug)]
enum Shown {
    Lagged(Arc<PublishedPicture>),
    Now(Arc<Picture>),
}

impl Second {
    /// Of a slot that is published; `None` between two seconds, and where there is no such picture.
    pub fn of(frame: &Arc<PublishedPicture>, kind: PictureKind, hub: &Hub) -> Option<Self> {
        let shown = match kind {
            PictureKind::Lagged => Shown::Lagged(frame.clone()),
            PictureKind::Now => Shown::Now(frame.now.get()?),
        };
        let second = Self {
            maker: hub.maker.clone(),
            due: frame.due,
            kind,
            level: hub.condition().level(),
            shown,
            max_accuracy_m: hub.config.output.max_accuracy_m,
        };
        hub.maker.begins_second(second.picture().slot).then_some(second)
    }

    /// The picture.
    pub fn picture(&self) -> &Picture {
        match &self.shown {
            Shown::Lagged(frame) => &frame.picture,
            Shown::Now(picture) => picture,
        }
    }

    /// Its tracks, without those that are known too poorly (`output.max_accuracy_m`).
    pub fn tracks(&self) -> impl Iterator<Item = &PictureTrack> {
        self.picture().within(self.max_accuracy_m)
    }
}
