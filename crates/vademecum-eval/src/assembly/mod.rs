//! Bodies joined at bind: component mode synthesis of files at their ports, in lent memory.

pub(crate) mod assembly;
pub(crate) mod carry;
pub(crate) mod counts;
pub(crate) mod damping;
pub(crate) mod error;
pub(crate) mod facet;
pub(crate) mod inputs;
pub(crate) mod joint;
pub(crate) mod part;
pub(crate) mod port;
pub(crate) mod residual;
pub(crate) mod rows;
pub(crate) mod states;
pub(crate) mod synthesis;
pub(crate) mod text;
pub(crate) mod write;
