//! The tabs of both sides of the window, and which of them is in front.

/// The tab of the inspector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inspector {
    /// The selected material.
    #[default]
    Material,
    /// The environment.
    Environment,
    /// Local lights, and the parts of the light in the picture.
    Lights,
    /// Settings of the picture and its display.
    View,
    /// Visibility.
    Bake,
}

impl Inspector {
    /// All tabs, in the order shown.
    pub const ALL: [Self; 5] = [Self::Material, Self::Environment, Self::Lights, Self::View, Self::Bake];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Material => "Material",
            Self::Environment => "Environment",
            Self::Lights => "Lights",
            Self::View => "View",
            Self::Bake => "Bake",
        }
    }
}

/// The tab of the left side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Objects, materials and cameras.
    #[default]
    Scene,
    /// Looks to go back to.
    Looks,
    /// The library of environments.
    Library,
}

impl Side {
    /// All tabs, in the order shown.
    pub const ALL: [Self; 3] = [Self::Scene, Self::Looks, Self::Library];

    /// Its name.
    pub fn label(self) -> &'static str {
        match self {
            Self::Scene => "Scene",
            Self::Looks => "Looks",
            Self::Library => "Library",
        }
    }
}

/// The visible panels and tabs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tabs {
    /// The tab of the inspector.
    pub inspector: Inspector,
    /// The tab of the left side.
    pub side: Side,
    /// Whether only the picture is shown.
    pub panels_hidden: bool,
    /// Which sides are opened over the picture in a narrow window: the left one, and the inspector.
    pub unfolded: [bool; 2],
}

impl Tabs {
    /// Brings a tab of the inspector to the front, and shows the inspector if it is hidden.
    pub fn show_inspector(&mut self, tab: Inspector) {
        (self.inspector, self.panels_hidden) = (tab, false);
        self.unfolded[1] = true;
    }
}
