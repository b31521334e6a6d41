"""The thesis' input and output files (Léveillé 2013, appendix A): read, run, written, converted to cases and back."""

from ssmash_gym.thesis_files.case import Reading, read_case, read_folder
from ssmash_gym.thesis_files.outputs import write_outputs
from ssmash_gym.thesis_files.writing import Written, write_case

__all__ = ["Reading", "Written", "read_case", "read_folder", "write_case", "write_outputs"]
