//! Data for the sinks: one picture per second.

use std::sync::Arc;

use crate::live::{Hub, PublishedPicture, ServiceLevel};
use fusion::time::Time;
use picture::{Picture, PictureMaker, PictureTrack};
use site::config::PictureKind;

/// A second's picture, with the data that a receiver needs beside it.
#[derive(Clone, Debug)]
pub struct PictureSecond {
    /// Names the tracks.
    pub maker: Arc<PictureMaker>,
    /// Time at which the slot was due.
    pub due: Time,
    /// Kind of the picture.
    pub kind: PictureKind,
    /// Level of the service's condition.
    pub level: ServiceLevel,
    shown: SharedPicture,
    max_accuracy_m: f64,
}

/// Shares the picture instead of copying it.
#[derive(Clone, Debug)]
enum SharedPicture {
    Lagged(Arc<PublishedPicture>),
    Now(Arc<Picture>),
}

impl PictureSecond {
    /// Picture of a published slot; `None` between two seconds, and if there is no such picture.
    pub fn of(frame: &Arc<PublishedPicture>, kind: PictureKind, hub: &Hub) -> Option<Self> {
        let shown = match kind {
            PictureKind::Lagged => SharedPicture::Lagged(frame.clone()),
            PictureKind::Now => SharedPicture::Now(frame.now.get()?),
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
            SharedPicture::Lagged(frame) => &frame.picture,
            SharedPicture::Now(picture) => picture,
        }
    }

    /// Tracks of the picture with sufficient accuracy (`output.max_accuracy_m`).
    pub fn tracks(&self) -> impl Iterator<Item = &PictureTrack> {
        self.picture().within(self.max_accuracy_m)
    }
}
