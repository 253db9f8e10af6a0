//! A file bound to parameters, and the states and loads that go with it.

pub(crate) mod bind;
pub(crate) mod cost;
pub(crate) mod coupled;
pub(crate) mod equation;
pub(crate) mod increment;
pub(crate) mod loads;
pub(crate) mod rest;
pub(crate) mod scene;
pub(crate) mod shape;
pub(crate) mod state;
