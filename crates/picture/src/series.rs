//! Pictures of successive emissions: of a service, a replay or a cell.

use crate::{Picture, PictureMaker, TrackNames, UncooperativeDetector};
use fusion::Emission;

/// Makes the pictures of successive emissions. Adds what depends on earlier pictures: names, and drones without a
/// transponder.
#[derive(Clone, Debug)]
pub struct PictureSeries {
    maker: PictureMaker,
    /// Detector of drones without a transponder.
    pub detector: UncooperativeDetector,
    names: TrackNames,
}

impl PictureSeries {
    /// Series whose pictures `maker` makes.
    pub fn new(maker: PictureMaker, detector: UncooperativeDetector) -> Self {
        Self { maker, detector, names: TrackNames::default() }
    }

    /// Maker of the pictures.
    pub fn maker(&self) -> &PictureMaker {
        &self.maker
    }

    /// Picture of an emission and, if it has one and `is_now_wanted`, the picture of now.
    pub fn pictures(&mut self, mut emission: Emission, is_now_wanted: bool) -> (Picture, Option<Picture>) {
        let now = emission.now.take().filter(|_| is_now_wanted).map(|now| self.maker.now(now));
        let mut picture = self.maker.picture(emission);
        self.detector.look(&mut picture, &self.maker);
        self.names.name(&mut picture);
        let now = now.map(|mut now| {
            now.mark_as(&picture);
            self.names.label(&mut now);
            now
        });
        (picture, now)
    }
}
