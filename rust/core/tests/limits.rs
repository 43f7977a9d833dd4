//! The quick search for the limit of large meshes: within 1 % of the thorough one, on the safe side, in few products.
#![allow(missing_docs, clippy::unwrap_used)]

mod common;

use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use common::{Bench, FILM, film, sail, sheet};
use membrane_core::arrays::jacobian::JacobianBlocks;
use membrane_core::arrays::state::NodeVectors;
use membrane_core::integrators::{Options, by_name};
use membrane_core::laws::{FilmElements, Instant, Kernels, Law, LawSpec, Linearisation, Properties, WorkClass};
use membrane_core::model::input::{Creases, Model};
use membrane_core::stability::{Accuracy, Limit, limit_to};

/// A law without forces that counts the products of a search.
struct Counter(Arc<AtomicUsize>);

impl Law for Counter {
    fn properties(&self) -> Properties {
        let (work_class, depends_on_velocity, is_internal) = (WorkClass::Conservative, false, true);
        Properties { name: "counter", work_class, depends_on_velocity, is_internal }
    }

    fn kernels(&self) -> Kernels {
        Kernels::default()
    }

    fn linearisation(&self) -> Option<&dyn Linearisation> {
        Some(self)
    }

    fn remedy(&self) -> &'static str {
        ""
    }
}

impl Linearisation for Counter {
    fn add_stiffness_product(&self, _: Instant<'_>, _: &NodeVectors, _: &mut NodeVectors) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn add_damping_product(&self, _: f64, _: Instant<'_>, _: &NodeVectors, _: &mut NodeVectors) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn add_jacobian(&self, _: Instant<'_>, _: &mut dyn JacobianBlocks) {}
}

/// A disc with a hole, of rings whose triangles become smaller towards the centre.
fn disc(rings: u32, sectors: u32) -> Model {
    let node = |ring: u32, sector: u32| ring * sectors + sector % sectors;
    let mut model = Model { film: Some(FILM), ..Model::default() };
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (radius, angle) = (0.02 + 0.1 * f64::from(ring) / f64::from(rings), TAU * f64::from(sector));
            let (sine, cosine) = (angle / f64::from(sectors)).sin_cos();
            model.reference.push([radius * cosine, radius * sine, 0.0]);
        }
    }
    for (ring, sector) in (0..rings).flat_map(|ring| (0..sectors).map(move |sector| (ring, sector))) {
        let [a, b] = [node(ring, sector), node(ring + 1, sector)];
        let [c, d] = [node(ring + 1, sector + 1), node(ring, sector + 1)];
        model.triangles.extend([[a, b, c], [a, c, d]]);
    }
    model.positions = model.reference.iter().map(|[x, y, _]| [1.001 * x, 1.001 * y, 3.0 * x * x]).collect();
    model.velocities = vec![[0.0, 0.0, 1.0]; model.positions.len()];
    model.extra_masses = vec![0.0; model.positions.len()];
    model
}

/// The sail of model 1, twice as fine, with this law in place of one of its kind.
fn sail_with(law: LawSpec) -> (Model, Vec<LawSpec>) {
    let is_other = |other: &LawSpec| other.kind() != law.kind() && (law.film().is_none() || other.film().is_none());
    let mut laws: Vec<LawSpec> = sail::laws().into_iter().filter(is_other).collect();
    laws.insert(0, law);
    (sail::sail(2), laws)
}

/// Scenes whose limit is set by few nodes, or by many of the same kind.
fn scenes() -> Vec<(&'static str, Model, Vec<LawSpec>)> {
    let plain = || {
        let mut model = sail::sail(2);
        model.extra_masses.iter_mut().take(sail::node_count(2)).for_each(|mass| *mass = 0.0);
        model
    };
    let creases = |laws: Vec<LawSpec>| {
        let stiffer = |law: LawSpec| match law {
            LawSpec::Creases(creases) => {
                LawSpec::Creases(membrane_core::laws::CreaseParameters { stiffness: 1e4, ..creases })
            }
            other => other,
        };
        laws.into_iter().map(stiffer).collect::<Vec<_>>()
    };
    let undamped = || sail::laws().into_iter().filter(|law| !matches!(law, LawSpec::SpringDamping(_))).collect();
    let triangles = film(FilmElements::Triangles);
    let (film_of_rectangles, laws_of_rectangles) = sail_with(film(FilmElements::Rectangles));
    let strip = Model { creases: Creases::default(), ..sheet(1000, 3, 0.01) };
    let (damped, laws_of_damped) = sail_with(LawSpec::SpringDamping(0.5.into()));
    let (film_of_triangles, laws_of_triangles) = sail_with(triangles.clone());
    vec![
        ("sail with tip masses and tethers", sail::sail(2), sail::laws()),
        ("sail without tip masses", plain(), sail::laws()),
        ("sail without dashpots", sail::sail(2), undamped()),
        ("sail, strongly damped", damped, laws_of_damped),
        ("sail of triangles", film_of_triangles, laws_of_triangles),
        ("sail of rectangles", film_of_rectangles, laws_of_rectangles),
        ("sail with stiff creases", plain(), creases(sail::laws())),
        ("disc", disc(40, 90), vec![common::springs(), LawSpec::SpringDamping(0.02.into())]),
        ("disc of triangles", disc(40, 90), vec![triangles, LawSpec::SpringDamping(0.1.into())]),
        ("sheet with creases", sheet(60, 60, 0.01), vec![common::springs(), common::creases(1.0)]),
        ("strip", strip, vec![common::springs(), LawSpec::SpringDamping(0.02.into())]),
    ]
}

/// The limit to an accuracy, and the number of products that it takes.
fn found(bench: &Bench, method: &str, accuracy: Accuracy) -> (Limit, usize) {
    let (integrator, count) = ((by_name(method).unwrap().make)(&Options::default()), Arc::new(AtomicUsize::new(0)));
    let counter = Counter(count.clone());
    // The law outside the list changes as it is used.
    let laws = bench.laws.iter().map(AsRef::as_ref).filter(|law: &&dyn Law| law.name() != "wearing_friction");
    let laws: Vec<&dyn Law> = laws.chain([&counter as &dyn Law]).collect();
    let limit = limit_to(accuracy, integrator.as_ref(), &laws, bench.instant(), &bench.assembly.inverse_masses);
    (limit.unwrap(), count.load(Ordering::Relaxed))
}

#[test]
fn a_quick_limit_is_safe_and_within_one_percent_in_few_products() {
    for (name, model, laws) in scenes() {
        let bench = Bench::new(model, &laws);
        let (thorough, _) = found(&bench, "leapfrog", Accuracy::Thorough);
        let (quick, products) = found(&bench, "leapfrog", Accuracy::Percent);
        let (step, frequency) = (quick.dt / thorough.dt, quick.largest_frequency / thorough.largest_frequency);
        println!("{name}: step {step:.5}, frequency {frequency:.5}, {products} products, {}", quick.law);
        assert!((0.99..1.0005).contains(&step), "{name}: {step}");
        assert!((0.9995..1.01).contains(&frequency), "{name}: {frequency}");
        assert_eq!(quick.law, thorough.law, "{name}");
        assert!(products <= 120, "{name}: {products} products");
    }
}

#[test]
fn a_quick_limit_by_roots_is_within_one_percent() {
    for (name, model, laws) in scenes().into_iter().take(1) {
        let bench = Bench::new(model, &laws);
        let of = |accuracy| found(&bench, "rk4", accuracy).0.dt;
        let ratio = of(Accuracy::Percent) / of(Accuracy::Thorough);
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
}
