//! Created messages: values are read back, and the values of any octets can be written again.

use proptest::option::of;
use proptest::prelude::*;
use remote_id::{
    BasicId, HeightAbove, IdType, LENGTH, Location, LocationContent, Message, Status, System, SystemContent,
    UaType, messages, pack,
};

fn altitude() -> impl Strategy<Value = Option<f64>> {
    of((1..=u16::MAX).prop_map(|count| 0.5 * f64::from(count) - 1000.0))
}

fn one_of(values: &'static [f64]) -> impl Strategy<Value = Option<f64>> {
    of(prop::sample::select(values))
}

const HORIZONTAL_M: &[f64] =
    &[18_520.0, 7_408.0, 3_704.0, 1_852.0, 926.0, 555.6, 185.2, 92.6, 30.0, 10.0, 3.0, 1.0];
const VERTICAL_M: &[f64] = &[150.0, 45.0, 25.0, 10.0, 3.0, 1.0];
const SPEED_M_S: &[f64] = &[10.0, 3.0, 1.0, 0.3];

fn place() -> impl Strategy<Value = Option<[f64; 2]>> {
    let place = (-900_000_000..=900_000_000, -1_800_000_000..=1_800_000_000);
    of(place.prop_filter("0, 0 is unknown", |place| *place != (0, 0))).prop_map(|place| {
        place.map(|(latitude, longitude)| [latitude, longitude].map(|count: i32| f64::from(count) * 1e-7))
    })
}

prop_compose! {
    fn location()(
        status in 0u8..16,
        course in of(0u16..360),
        speed in of(prop_oneof![
            (0u8..=255).prop_map(|count| 0.25 * f64::from(count)),
            (1u8..=254).prop_map(|count| 0.75 * f64::from(count) + 63.75),
        ]),
        climb in of(-124i8..=124),
        place in place(),
        altitudes in (altitude(), altitude(), altitude(), any::<bool>()),
        accuracies in (one_of(HORIZONTAL_M), one_of(VERTICAL_M), one_of(VERTICAL_M), one_of(SPEED_M_S)),
        tenths in of(0u16..=36_000),
        accuracy_time in of(1u8..=15),
    ) -> LocationContent {
        let above = if altitudes.3 { HeightAbove::Ground } else { HeightAbove::TakeOff };
        LocationContent {
            status: [Status::Undeclared, Status::Ground, Status::Airborne, Status::Emergency, Status::SystemFailure]
                .get(usize::from(status)).copied().unwrap_or(Status::Reserved(status)),
            course_deg: course.map(f64::from),
            speed_m_s: speed,
            climb_m_s: climb.map(|count| 0.5 * f64::from(count)),
            place_deg: place,
            pressure_altitude_m: altitudes.0,
            geodetic_altitude_m: altitudes.1,
            height_m: altitudes.2.map(|metres| (metres, above)),
            accuracy_h_m: accuracies.0,
            accuracy_v_m: accuracies.1,
            accuracy_pressure_m: accuracies.2,
            accuracy_speed_m_s: accuracies.3,
            seconds_of_hour: tenths.map(|tenths| f64::from(tenths) * 0.1),
            accuracy_time_s: accuracy_time.map(|tenths| f64::from(tenths) * 0.1),
        }
    }
}

prop_compose! {
    fn system()(
        types in (0u8..4, 0u8..8, 0u8..16, 0u8..16),
        place in place(),
        area in (any::<u16>(), any::<u8>(), altitude(), altitude()),
        operator_altitude_m in altitude(),
        time_s in any::<u32>(),
    ) -> SystemContent {
        SystemContent {
            location_type: types.0,
            classification: types.1,
            operator_deg: place,
            area_count: area.0,
            area_radius_m: 10.0 * f64::from(area.1),
            area_ceiling_m: area.2,
            area_floor_m: area.3,
            category_and_class: [types.2, types.3],
            operator_altitude_m,
            time_s,
        }
    }
}

proptest! {
    #[test]
    fn a_location_is_read_as_it_was_made(content in location()) {
        let Ok(Message::Location(read)) = Message::new(*Message::Location(Location::new(&content)).octets()) else { panic!() };
        prop_assert_eq!(read.content(), content);
    }

    #[test]
    fn a_system_is_read_as_it_was_made(content in system()) {
        let Ok(Message::System(read)) = Message::new(*Message::System(System::new(&content)).octets()) else { panic!() };
        prop_assert_eq!(read.content(), content);
    }

    /// The values of any octets can be encoded again and remain the same.
    #[test]
    fn decoded_octets_are_encoded_identically(octets in prop::array::uniform25(any::<u8>())) {
        let mut octets = octets;
        octets[0] = 0x12;
        let Ok(Message::Location(location)) = Message::new(octets) else { panic!() };
        let content = location.content();
        // Vertical speeds of -63.5 and -64 m/s are out of range; the fine steps end where the coarse ones begin.
        if content.climb_m_s.is_none_or(|climb| climb.abs() <= 62.0) {
            prop_assert_eq!(Location::new(&content).content(), content);
        }
        octets[0] = 0x42;
        let Ok(Message::System(system)) = Message::new(octets) else { panic!() };
        prop_assert_eq!(System::new(&system.content()).content(), system.content());
    }

    #[test]
    fn any_values_make_a_message(values in prop::array::uniform8(any::<f64>())) {
        let some = |index: usize| Some(values[index]);
        let content = LocationContent {
            status: Status::Airborne,
            course_deg: some(0),
            speed_m_s: some(1),
            climb_m_s: some(2),
            place_deg: Some([values[3], values[4]]),
            pressure_altitude_m: some(5),
            geodetic_altitude_m: some(6),
            height_m: Some((values[7], HeightAbove::Ground)),
            accuracy_h_m: some(0),
            accuracy_v_m: some(1),
            accuracy_pressure_m: some(2),
            accuracy_speed_m_s: some(3),
            seconds_of_hour: some(4),
            accuracy_time_s: some(5),
        };
        let made = Location::new(&content);
        prop_assert_eq!(Message::new(*Message::Location(made).octets()), Ok(Message::Location(made)));
        prop_assert!(made.course_deg().is_some() && made.geodetic_altitude_m().is_some());
    }
}

#[test]
fn a_pack_holds_one_to_nine() {
    let id = Message::BasicId(BasicId::new(IdType::SerialNumber, UaType::Rotorcraft, b"SIMU7000001A"));
    for count in 1..=9 {
        let octets = pack(&vec![id; count]).expect("up to nine");
        assert_eq!(octets.len(), 3 + count * LENGTH);
        assert!(messages(&octets).eq(std::iter::repeat_n(Ok(id), count)));
    }
    assert_eq!((pack(&[]), pack(&[id; 10])), (None, None));
}
