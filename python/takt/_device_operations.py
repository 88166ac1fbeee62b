"""The operations of each kind of device, from the tables of the core. Types: _device_operations.pyi, printed by
`python3 -m takt.stubs`."""
from ._operations import operations_of

ArmOperations = type("ArmOperations", (), operations_of("arm"))
GripperOperations = type("GripperOperations", (), operations_of("gripper"))
ToolChangerOperations = type("ToolChangerOperations", (), operations_of("tool_changer"))
OutputOperations = type("OutputOperations", (), operations_of("output"))
CellOperations = type("CellOperations", (), operations_of(""))
