//! Remedies for renderer errors. The library words them generally; a front end names its own options.

/// A change that avoids an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Remedy {
    /// Compute on the CPU.
    Cpu,
    /// A bake of fewer vertices.
    FewerVertices,
    /// A bake of smaller visibility cuts.
    SmallerCuts,
    /// A bake of a meshless basis with fewer levels.
    FewerFunctions,
    /// A picture of fewer pixels.
    SmallerPicture,
    /// A bake of the environment's visibility.
    EnvironmentBake,
    /// A bake of surface sources.
    SourceBake,
}

/// A front end's wording of each remedy.
pub type Wording = fn(Remedy) -> &'static str;

impl Remedy {
    /// The remedy as a plain instruction.
    pub fn words(self) -> &'static str {
        match self {
            Self::Cpu => "render on the CPU",
            Self::FewerVertices => "bake fewer vertices",
            Self::SmallerCuts => "bake with larger sigmas or fewer vertices",
            Self::FewerFunctions => "bake with fewer levels of the meshless basis",
            Self::SmallerPicture => "render a smaller picture",
            Self::EnvironmentBake => "bake it with the environment",
            Self::SourceBake => "bake it with surface sources",
        }
    }
}
