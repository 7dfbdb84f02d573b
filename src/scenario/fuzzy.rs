//! The fuzzy basis ξ(x) and the compensator ρ̂ = W ξ(x).

use serde::{Deserialize, Serialize};

use super::inputs::InputSettings;
use super::numbers::{Numbers, PerJoint, agreed};
use crate::control::{Adaptation, FuzzyParameters, KernelParameters};
use crate::error::{Error, Result, at_most, length, non_negative, within};
use crate::fuzzy::{Axis, Form, FuzzyBasis, KernelBasis, MAX_INPUTS};

/// How sets combine to rules, before an arm says how many joints there are: see [`Form`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rules {
    /// A rule for every combination of one set per input.
    Grid,
    /// Rule j uses set j on every input.
    Shared,
    /// A rule for every set of every input.
    Concat,
    /// A grid for each joint.
    PerJoint,
}

impl Rules {
    /// All of them, by name.
    pub const NAMES: [(&str, Self); 4] = [
        ("grid", Self::Grid),
        ("shared", Self::Shared),
        ("concat", Self::Concat),
        ("per_joint", Self::PerJoint),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, rules)| *rules == self).map_or("", |(name, _)| name)
    }

    /// For an arm.
    pub fn form(self, joints: usize) -> Form {
        match self {
            Self::Grid => Form::Grid,
            Self::Shared => Form::Shared,
            Self::Concat => Form::Concat,
            Self::PerJoint => Form::PerJoint { joints },
        }
    }
}

/// Parameters of a [`FuzzyBasis`] or a [`KernelBasis`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BasisSettings {
    /// How sets combine to rules.
    pub form: Rules,
    /// Centres: a list for all inputs, or a list an input.
    pub centers: Numbers,
    /// σ: a number, one a set, one an input, or a list an input.
    pub width: Numbers,
    /// Fuzzy basis functions, or raw firing strengths.
    #[serde(default = "yes")]
    pub normalized: bool,
    /// The signals that it sees.
    #[serde(default)]
    pub inputs: InputSettings,
    /// Joints of the arm; absent: those that the lists of centres are for, or any.
    #[serde(default)]
    pub joints: Option<usize>,
}

fn yes() -> bool {
    true
}

impl BasisSettings {
    /// Normalised, of the signals (e, ė), for any arm.
    pub fn new(form: Rules, centers: Numbers, width: Numbers) -> Self {
        Self { form, centers, width, normalized: yes(), inputs: Default::default(), joints: None }
    }

    /// The same with `joints` filled in where the lists of centres say it. Whether it is right for
    /// an arm shows where one is known.
    ///
    /// # Errors
    /// As [`build`](Self::build) and [`kernel`](Self::kernel), where the joints are known or any.
    pub fn checked(mut self) -> Result<Self> {
        let signals = self.inputs.build()?.len(1);
        if let (None, Some(lists)) = (self.joints, self.lists()) {
            let joints = lists / signals;
            self.joints = (joints > 0 && lists.is_multiple_of(signals)).then_some(joints);
        }
        if let Some(joints) = self.joints.or(self.lists().is_none().then_some(1)) {
            self.check_for(joints)?;
        }
        Ok(self)
    }

    /// Refuses what makes no basis for an arm; a grid may have any number of rules.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn check_for(&self, joints: usize) -> Result<()> {
        if self.form == Rules::Grid {
            self.kernel(joints).map(drop)
        } else {
            self.build(joints).map(drop)
        }
    }

    /// The basis for an arm of so many joints, with all its rules.
    ///
    /// # Errors
    /// As [`FuzzyBasis::new`]; `WrongLength`, naming `centers` or `width`, where the lists are for
    /// other inputs.
    pub fn build(&self, joints: usize) -> Result<FuzzyBasis> {
        self.over(self.inputs.len(joints), joints)
    }

    /// The basis over so many inputs, whatever they are.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn over(&self, inputs: usize, joints: usize) -> Result<FuzzyBasis> {
        FuzzyBasis::new(self.form.form(joints), self.normalized, &self.axes(inputs)?)
    }

    /// The grid for an arm in the kernel form.
    ///
    /// # Errors
    /// As [`KernelBasis::new`], and as [`build`](Self::build).
    pub fn kernel(&self, joints: usize) -> Result<KernelBasis> {
        KernelBasis::new(self.normalized, &self.axes(self.inputs.len(joints))?)
    }

    /// How many lists of centres there are, if not one for all inputs.
    pub fn lists(&self) -> Option<usize> {
        if let Numbers::Rows(rows) = &self.centers { Some(rows.len()) } else { None }
    }

    /// The sets of so many inputs.
    ///
    /// # Errors
    /// `WrongLength`, naming `centers` or `width`; `inputs`: more than [`MAX_INPUTS`].
    pub fn axes(&self, inputs: usize) -> Result<Vec<Axis<'_>>> {
        let lists = self.lists();
        length("centers", lists.unwrap_or(inputs), inputs)?;
        at_most("inputs", inputs, MAX_INPUTS)?;
        (0..inputs)
            .map(|k| Ok(Axis { centers: self.centers(k), widths: self.widths(k)? }))
            .collect()
    }

    fn centers(&self, k: usize) -> &[f64] {
        match &self.centers {
            Numbers::Same(centers) => centers.as_slice(),
            Numbers::Rows(rows) => &rows[k],
        }
    }

    fn widths(&self, k: usize) -> Result<&[f64]> {
        let lists = self.lists();
        match &self.width {
            Numbers::Same(PerJoint::Each(widths)) if lists.is_some() => {
                length("width", widths.len(), lists.unwrap_or(1))?;
                Ok(&widths[k..=k])
            }
            Numbers::Same(widths) => Ok(widths.as_slice()),
            Numbers::Rows(rows) => {
                length("width", rows.len(), lists.unwrap_or(1))?;
                Ok(&rows[if lists.is_some() { k } else { 0 }])
            }
        }
    }
}

/// Parameters of a fuzzy compensator, in either form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompensatorSettings {
    /// ξ and the signals that it sees.
    pub basis: BasisSettings,
    /// Diagonal of Q in (19): a number, or [e₁ … eₙ, ė₁ … ėₙ].
    #[serde(default = "q")]
    pub q: PerJoint,
    /// Γ⁻¹: a number, or one a joint.
    #[serde(default = "gain")]
    pub gain: PerJoint,
    /// γ of (19).
    #[serde(default = "gamma")]
    pub gamma: f64,
    /// See [`Adaptation`], as the next four.
    #[serde(default = "leak_rate")]
    pub leak_rate: f64,
    /// κ_e.
    #[serde(default = "error_modification")]
    pub error_modification: f64,
    /// Radius of the ball that |W − W₀| stays in.
    #[serde(default = "projection_radius")]
    pub projection_radius: f64,
    /// d₀.
    #[serde(default = "dead_zone")]
    pub dead_zone: f64,
    /// ν.
    #[serde(default = "normalization")]
    pub normalization: f64,
    /// Atoms of the kernel form; absent: every rule has its weight.
    #[serde(default)]
    pub dictionary: Option<usize>,
    /// See [`KernelParameters`]; only with a dictionary.
    #[serde(default)]
    pub merge_tolerance: Option<f64>,
}

/// The core's defaults, each under its name.
macro_rules! defaults {
    ($($name:ident: $type:ty = $value:expr;)*) => {
        $(fn $name() -> $type { $value })*
    };
}

defaults! {
    q: PerJoint = FuzzyParameters::<1>::default().q_position[0].into();
    gain: PerJoint = Adaptation::<1>::default().gain[0].into();
    gamma: f64 = FuzzyParameters::<1>::default().gamma;
    leak_rate: f64 = Adaptation::<1>::default().leak_rate;
    error_modification: f64 = Adaptation::<1>::default().error_modification;
    projection_radius: f64 = Adaptation::<1>::default().projection_radius;
    dead_zone: f64 = Adaptation::<1>::default().dead_zone;
    normalization: f64 = Adaptation::<1>::default().normalization;
}

impl CompensatorSettings {
    /// The paper's Q and γ, a gain of 1, no modification.
    pub fn new(basis: BasisSettings) -> Self {
        Self {
            basis,
            q: q(),
            gain: gain(),
            gamma: gamma(),
            leak_rate: leak_rate(),
            error_modification: error_modification(),
            projection_radius: projection_radius(),
            dead_zone: dead_zone(),
            normalization: normalization(),
            dictionary: None,
            merge_tolerance: None,
        }
    }

    /// The joints that it is for; `None`: any.
    ///
    /// # Errors
    /// `WrongLength`, naming `gain` or `q`: they are for different numbers of joints.
    pub fn joints(&self) -> Result<Option<usize>> {
        let joints = agreed(self.basis.joints, ("gain", self.gain.count()))?;
        agreed(joints.map(|joints| 2 * joints), ("q", self.q.count()))
            .map(|twice| twice.map(|entries| entries / 2))
    }

    /// The same, with a gain for each joint where the joints are known.
    ///
    /// # Errors
    /// As [`parameters`](Self::parameters), [`kernel`](Self::kernel) and
    /// [`BasisSettings::build`]; the basis is taken for checked.
    pub fn checked(mut self) -> Result<Self> {
        if let Some(entries) = self.q.count() {
            length("q", entries, 2 * entries.div_ceil(2))?;
        }
        let joints = self.joints()?;
        self.check_numbers(joints)?;
        let kernel = self.kernel()?;
        if let Some(joints) = joints {
            self.gain = PerJoint::Each(self.gain.values(joints));
            match kernel {
                Some(_) => self.basis.check_for(joints)?,
                None => self.basis.build(joints).map(drop)?,
            }
        }
        Ok(self)
    }

    fn check_numbers(&self, joints: Option<usize>) -> Result<()> {
        for (n, &gain) in self.gain.as_slice().iter().enumerate() {
            self.adaptation([gain]).validate().map_err(|error| {
                let of_joint = error.parameter() == "gain" && joints != Some(1);
                error.at(of_joint.then_some(n))
            })?;
        }
        non_negative("q", &self.q.values(2))?;
        if self.gamma == f64::INFINITY {
            return Ok(());
        }
        within("gamma", &[self.gamma], |gamma| gamma > 0.0, "a number > 0, or infinity")
    }

    fn adaptation<const N: usize>(&self, gain: [f64; N]) -> Adaptation<N> {
        let Self {
            leak_rate, error_modification, projection_radius, dead_zone, normalization, ..
        } = *self;
        Adaptation {
            gain,
            leak_rate,
            error_modification,
            projection_radius,
            dead_zone,
            normalization,
        }
    }

    /// The core's parameters for `N` joints.
    ///
    /// # Errors
    /// `WrongLength`, naming `gain` or `q`; as [`InputSettings::build`].
    pub fn parameters<const N: usize>(&self) -> Result<FuzzyParameters<N>> {
        let adaptation = self.adaptation(self.gain.each("gain")?);
        let q = self.q.values(2 * N);
        length("q", q.len(), 2 * N)?;
        let half = |offset: usize| std::array::from_fn(|n| q[offset + n]);
        let (q_position, q_velocity) = (half(0), half(N));
        let inputs = self.basis.inputs.build()?;
        Ok(FuzzyParameters { inputs, q_position, q_velocity, gamma: self.gamma, adaptation })
    }

    /// The parameters of the kernel form; `None`: every rule has its weight.
    ///
    /// # Errors
    /// `dictionary`: out of range, or of a basis that is no grid; `merge_tolerance`: out of range,
    /// or without a dictionary.
    pub fn kernel(&self) -> Result<Option<KernelParameters>> {
        let Self { dictionary, merge_tolerance, .. } = *self;
        let Some(capacity) = dictionary else {
            let wanted = "a dictionary too, such as dictionary = 256";
            return merge_tolerance
                .map_or(Ok(None), |got| Err(Error::out_of_range("merge_tolerance", got, wanted)));
        };
        let usual = KernelParameters::default().merge_tolerance;
        let merge_tolerance = merge_tolerance.unwrap_or(usual);
        let kernel = KernelParameters { capacity, merge_tolerance };
        kernel.validate().map_err(|error| match error.parameter() {
            "capacity" => error.named("dictionary"),
            _ => error,
        })?;
        if self.basis.form != Rules::Grid {
            let wanted = "form = \"grid\": no other has a kernel form";
            return Err(Error::out_of_range("dictionary", capacity as f64, wanted));
        }
        Ok(Some(kernel))
    }
}
