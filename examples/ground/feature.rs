//! Features of the ground, in the layers and classes of OpenMapTiles.

/// Metres east and north of the scenarios' origin.
pub type Place = [f64; 2];

/// A thing on the ground.
pub struct Feature {
    /// Layer of the vector tiles.
    pub layer: &'static str,
    /// Its class in that layer.
    pub class: &'static str,
    /// Name; only places have one.
    pub name: Option<&'static str>,
    /// Its shape.
    pub shape: Shape,
    /// Lowest zoom that shows it.
    pub zoom: u8,
}

/// Shape of a feature.
pub enum Shape {
    /// One place.
    Point(Place),
    /// A line from the first place to the last.
    Line(Vec<Place>),
    /// The area inside a ring, whose last place is joined to the first.
    Area(Vec<Place>),
}

impl Feature {
    /// A line.
    pub fn line(layer: &'static str, class: &'static str, zoom: u8, line: Vec<Place>) -> Self {
        Self { layer, class, name: None, shape: Shape::Line(line), zoom }
    }

    /// An area.
    pub fn area(layer: &'static str, class: &'static str, zoom: u8, ring: Vec<Place>) -> Self {
        Self { layer, class, name: None, shape: Shape::Area(ring), zoom }
    }

    /// A name at a place.
    pub fn place(class: &'static str, name: &'static str, zoom: u8, place: Place) -> Self {
        Self { layer: "place", class, name: Some(name), shape: Shape::Point(place), zoom }
    }
}
