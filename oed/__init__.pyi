# What a notebook needs, and only that; each name is loaded when it is used.
from .commands.check import check as check
from .commands.design import design_motion as design_motion
from .commands.diagnose import diagnose_data as diagnose_data
from .commands.feasible import identify_feasible as identify_feasible
from .commands.hand_on import export_model as export_model
from .commands.hand_on import export_motion as export_motion
from .commands.identify import identify as identify
from .commands.import_log import import_log as import_log
from .errors import OedError as OedError
from .experiment.dataset import DataSet as DataSet
from .experiment.read_dataset import read_dataset as read_dataset
from .experiment.write_dataset import write_dataset as write_dataset
from .export.model import Model as Model
from .export.model_file import load_model as load_model
from .report.estimation_plots import plot_residuals as plot_residuals
from .report.estimation_plots import plot_torques as plot_torques
from .report.motion_recording import show_motion as show_motion
from .robot import Robot as Robot
from .robot import load_arm as load_arm

__version__: str
__all__: list[str]
