//! How offsets of heights are applied.

use super::*;

#[test]
fn offset_is_applied_once_evident_and_slowly() {
    let mut own = OwnHeights::new(3.0, Time::from_nanos(0));
    let offset = |probability| HeightOffset { probability, mean_m: 30.0, variance_m2: 9.0, information: 1.0 };
    let mut apply = |probability, seconds: usize| {
        own.offsets.insert(SensorIndex(0), offset(probability));
        (0..seconds).for_each(|_| own.apply(1.0));
        (own.applied_m, own.correction())
    };
    let (applied_m, unsure) = apply(0.6, 100);
    assert!(applied_m == 0.0 && unsure.contradiction.is_some());
    // The offset is no part of the height yet, and of its accuracy as far as it is likely.
    assert!((400.0..600.0).contains(&unsure.left_m2), "{unsure:?}");
    let (applied_m, sure) = apply(0.99, 20);
    assert_eq!(applied_m, 20.0 * HEIGHT_SLEW_M_S);
    assert!(sure.left_m2 > 380.0, "{sure:?}");
    let (applied_m, known) = apply(0.5, 100);
    assert!(applied_m == 30.0, "evident until released");
    assert!(known.left_m2 > 9.0 * 0.3, "{known:?}");
    let (applied_m, none) = apply(0.1, 100);
    assert!(applied_m == 0.0 && none.contradiction.is_none() && none.left_m2 == 0.0, "{none:?}");
}
