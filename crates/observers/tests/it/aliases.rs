//! The aliases of observers whose sizes are known at compile time name the types that the constructors give.

use luenberger_observers::mean_value::{Integral, MappedObserver, MeanValueObserver, StaticMeanValueObserver};
use luenberger_observers::{
    DeviationObserver, DiscreteNonlinearObserver, Observer, ObserverDimensions, ObserverError,
    ProportionalIntegralObserver, SampledObserver, StaticDeviationObserver, StaticDiscreteNonlinearObserver,
    StaticLinearObserver, StaticMappedObserver, StaticProportionalIntegralObserver, StaticUnknownInputObserver,
    UnknownInputObserver,
};
use luenberger_plants::StaticPlant;
use luenberger_plants::coordinates::InCoordinates;
use nalgebra::{Const, Matrix2, Vector1, Vector2};

type Plant = StaticPlant<f64, 2, 1, 1>;
type Inner = StaticMeanValueObserver<InCoordinates<Plant, f64, Const<2>>, Integral, f64, 2, 1, 1>;
type Linear = StaticLinearObserver<f64, 2, 1, 1>;

const SIZE: ObserverDimensions = ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 };

#[test]
fn aliases_name_the_types_that_the_constructors_give() -> Result<(), ObserverError> {
    let plant = luenberger_plants::double_integrator();
    let linear: Linear = Linear::of(plant.clone(), Vector2::new(7.0, 10.0))?;
    let observer: StaticDeviationObserver<Linear, f64, 2, 1, 1> =
        DeviationObserver::new(linear.clone(), Vector2::new(1.0, 0.0), Vector1::new(0.5), Vector1::new(1.0))?;
    assert_eq!(Observer::dimensions(&observer), SIZE);
    let observer: StaticProportionalIntegralObserver<Linear, 1> =
        ProportionalIntegralObserver::new(linear.clone(), Const)?;
    assert_eq!(observer.dimensions(), ObserverDimensions { estimate: 1, ..SIZE });
    let observer: StaticUnknownInputObserver<Linear, f64, 2, 1, 1> =
        UnknownInputObserver::new(linear, Vector2::new(1.0, 0.0), None)?;
    assert_eq!(observer.dimensions(), SIZE);
    let observer: StaticDiscreteNonlinearObserver<Plant, f64, 2, 1, 1> =
        DiscreteNonlinearObserver::new(plant.clone(), Vector2::new(0.5, 0.25), 0.1)?;
    assert_eq!(observer.dimensions(), SIZE);

    let other = InCoordinates::measured_first(plant, Matrix2::identity())?;
    let inner: Inner = MeanValueObserver::new(other.clone(), 1.0, Integral, Vector2::zeros())?;
    let observer: StaticMappedObserver<Inner, f64, 2> = MappedObserver::new(&other, inner);
    assert_eq!(observer.dimensions(), ObserverDimensions { state: 4, ..SIZE });
    Ok(())
}
