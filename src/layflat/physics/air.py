"""Constants of air, as an ideal gas, and of the reference atmosphere.

| name | meaning | unit |
|---|---|---|
| GAS_CONSTANT | specific gas constant R | J/(kg K) |
| GAMMA | ratio of specific heats | 1 |
| CV, CP | specific heats at constant volume and pressure | J/(kg K) |
| REFERENCE_DENSITY | rho0 of ISO 6358 (ISO 8778: 20 degC, 1 bar, 65 % humidity) | kg/m3 |
| REFERENCE_TEMPERATURE | T0 of ISO 6358 | K |
| NORMAL_DENSITY | density at 0 degC and 1.01325 bar, for air given in normal litres | kg/m3 |
"""

GAS_CONSTANT = 287.05
GAMMA = 1.4
CV = GAS_CONSTANT / (GAMMA - 1.0)
CP = CV + GAS_CONSTANT
REFERENCE_DENSITY = 1.185
REFERENCE_TEMPERATURE = 293.15
NORMAL_DENSITY = 101325.0 / (GAS_CONSTANT * 273.15)
