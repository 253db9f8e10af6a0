//! Materials that go by a name, with sources of their numbers.

/// An isotropic material by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedMaterial {
    /// Name.
    pub name: &'static str,
    /// Young's modulus \[Pa\].
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density \[kg/m³\].
    pub density: f64,
    /// Damping ratio that is usual for parts made of it.
    pub damping: f64,
    /// Source of the numbers.
    pub source: &'static str,
}

const fn material(
    name: &'static str,
    [young, poisson, density, damping]: [f64; 4],
    source: &'static str,
) -> NamedMaterial {
    NamedMaterial { name, young, poisson, density, damping, source }
}

const ASHBY: &str = "middle of the range in Ashby, Materials Selection in Mechanical Design";
const TISSUE: &str = "order of magnitude of Fung, Biomechanics; measure yours";

/// The materials that go by a name.
pub const MATERIALS: [NamedMaterial; 16] = [
    material("steel", [210e9, 0.30, 7850.0, 0.01], "EN 1993-1-1, 3.2.6"),
    material("stainless", [200e9, 0.30, 7900.0, 0.01], "EN 1993-1-4, 2.1.3"),
    material("aluminium", [70e9, 0.30, 2700.0, 0.01], "EN 1999-1-1, 3.2.5"),
    material("titanium", [115e9, 0.34, 4430.0, 0.01], ASHBY),
    material("brass", [100e9, 0.34, 8500.0, 0.005], ASHBY),
    material("concrete", [31e9, 0.20, 2500.0, 0.02], "EN 1992-1-1, class C25/30"),
    material("glass", [70e9, 0.23, 2500.0, 0.002], "EN 572-1"),
    material("wood", [11e9, 0.35, 420.0, 0.02], "EN 338, class C24 along the grain, taken as isotropic"),
    material("pla", [3.5e9, 0.36, 1240.0, 0.03], ASHBY),
    material("abs", [2.2e9, 0.37, 1050.0, 0.03], ASHBY),
    material("nylon", [2.7e9, 0.39, 1140.0, 0.03], ASHBY),
    material("rubber", [5e6, 0.48, 1100.0, 0.05], ASHBY),
    material("silicone", [1e6, 0.48, 1100.0, 0.05], ASHBY),
    material("foam", [1e5, 0.30, 50.0, 0.10], ASHBY),
    material("bone", [17e9, 0.30, 1900.0, 0.03], TISSUE),
    material("liver", [5e3, 0.45, 1050.0, 0.10], TISSUE),
];
